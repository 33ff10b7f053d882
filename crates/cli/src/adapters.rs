//! `murano adapters`: the graphics adapters of this machine.

use anyhow::{Result, bail};
use clap::Args;
use murano_gpu::{AdapterReport, Gpu};
use serde_json::json;

use crate::terminal::{say, say_json};

/// Lists the Vulkan, Metal and DirectX 12 adapters, what each lacks, and which would be used
#[derive(Args)]
#[command(after_help = "Example:\n  murano adapters --json")]
pub struct Arguments {
    /// One line of JSON on stdout
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let adapters = Gpu::adapters();
    if arguments.json {
        let list: Vec<_> = adapters.iter().enumerate().map(|(index, adapter)| described(adapter, index == 0)).collect();
        say_json(&json!({ "adapters": list }))?;
    } else {
        for (index, adapter) in adapters.iter().enumerate() {
            let used = if index == 0 { "   <- used unless --adapter says otherwise" } else { "" };
            say(format!("{}{used}", adapter.name))?;
            say(format!("  {}, {}, driver {}", adapter.backend, adapter.kind, adapter.driver))?;
            let lacks = if adapter.missing.is_empty() { "nothing".into() } else { adapter.missing.join(", ") };
            say(format!("  lacks {lacks}"))?;
        }
    }
    if adapters.is_empty() {
        bail!(
            "no graphics adapter; install a Vulkan, Metal or DirectX 12 driver \
             (Debian/Ubuntu without a GPU: apt-get install mesa-vulkan-drivers libvulkan1)"
        );
    }
    Ok(())
}

fn described(adapter: &AdapterReport, used: bool) -> serde_json::Value {
    json!({
        "name": adapter.name,
        "backend": adapter.backend,
        "kind": adapter.kind,
        "driver": adapter.driver,
        "missing": adapter.missing,
        "software": adapter.software,
        "used": used,
    })
}
