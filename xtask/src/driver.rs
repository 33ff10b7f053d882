//! A graphics driver for this machine: found, or installed, or named.
//!
//! Metal and Direct3D 12 come with their systems. On Linux a Vulkan loader and a driver ("ICD", installable client driver)
//! are needed; Mesa's lavapipe draws on the CPU and so works on every machine.

use std::{
    collections::BTreeSet,
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use anyhow::{Result, bail};

/// What Debian and Ubuntu call the loader and Mesa's drivers, lavapipe among them.
const DEBIAN_PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// Makes sure that a program can open a GPU adapter, real or software, installing Mesa's where that is possible.
///
/// # Errors
/// When there is none and none could be installed; the message says what to install.
pub fn ensure() -> Result<()> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let Err(lack) = find() else { return Ok(()) };
    eprintln!("No usable Vulkan driver: {lack}.");
    if on_path("apt-get") && (is_root() || on_path("sudo")) {
        install_with_apt();
        match find() {
            Ok(driver) => {
                eprintln!("Installed; the driver is {}.", driver.display());
                return Ok(());
            }
            Err(lack) => bail!("installing {} did not help: {lack}.\n{}", DEBIAN_PACKAGES.join(" and "), advice()),
        }
    }
    bail!("no Vulkan driver, and no way to install one from here.\n{}", advice())
}

/// Whether a program of this name stands on the search path.
pub fn on_path(program: &str) -> bool {
    env::var_os("PATH").is_some_and(|path| env::split_paths(&path).any(|folder| is_program(&folder.join(program))))
}

/// Windows programs carry a suffix.
fn is_program(path: &Path) -> bool {
    path.is_file() || path.with_extension("exe").is_file()
}

/// The manifest of a driver that can work here, or what is missing.
fn find() -> Result<PathBuf, String> {
    let libraries = Libraries::list();
    if !libraries.contains("libvulkan.so.1") {
        return Err("the Vulkan loader (libvulkan.so.1) is not installed".into());
    }
    let hardware = has_gpu();
    let manifests = manifests();
    let driver = manifests.iter().find(|manifest| works(manifest, &libraries, hardware));
    driver.cloned().ok_or_else(|| {
        if manifests.is_empty() {
            "the Vulkan loader is there, but no driver".into()
        } else {
            "the drivers installed are for GPUs that this machine does not have, or their libraries are missing".into()
        }
    })
}

/// Whether the driver of this manifest has its library, and a GPU unless it draws on the CPU.
fn works(manifest: &Path, libraries: &Libraries, hardware: bool) -> bool {
    let Some(library) = library_of(manifest) else { return false };
    let software = ["lvp", "lavapipe", "swiftshader"].iter().any(|name| library.to_lowercase().contains(name));
    if !(software || hardware) {
        return false;
    }
    if library.contains('/') {
        // Relative to the manifest, or absolute (in which case join returns it as it is).
        manifest.parent().unwrap_or(Path::new("/")).join(&library).is_file()
    } else {
        libraries.contains(&library)
    }
}

/// `ICD.library_path` of a driver manifest, as the Vulkan loader reads it.
fn library_of(manifest: &Path) -> Option<String> {
    let manifest: serde_json::Value = serde_json::from_slice(&fs::read(manifest).ok()?).ok()?;
    Some(manifest["ICD"]["library_path"].as_str()?.to_owned())
}

/// Every driver manifest the Vulkan loader would look at, in its order ("Driver discovery on Linux", Vulkan-Loader docs).
fn manifests() -> Vec<PathBuf> {
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        if let Some(value) = env::var_os(name).filter(|value| !value.is_empty()) {
            return env::split_paths(&value)
                .flat_map(|path| if path.is_dir() { json_in(&path) } else { vec![path] })
                .collect();
        }
    }
    let home = env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
    let folders = |name: &str, default: &[PathBuf]| match env::var_os(name).filter(|value| !value.is_empty()) {
        Some(value) => env::split_paths(&value).collect::<Vec<_>>(),
        None => default.to_vec(),
    };
    let mut bases = folders("XDG_CONFIG_HOME", &[home.join(".config")]);
    bases.extend(folders("XDG_CONFIG_DIRS", &["/etc/xdg".into()]));
    bases.extend(["/usr/local/etc".into(), "/etc".into()]);
    bases.extend(folders("XDG_DATA_HOME", &[home.join(".local/share")]));
    bases.extend(folders("XDG_DATA_DIRS", &["/usr/local/share".into(), "/usr/share".into()]));
    bases.push("/run/opengl-driver/share".into());
    bases.iter().flat_map(|base| json_in(&base.join("vulkan/icd.d"))).collect()
}

/// The `.json` files of a folder in the order of their names.
fn json_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|end| end == "json")).collect();
    files.sort();
    files
}

/// Whether the kernel shows a GPU: a render node, NVIDIA's device, or WSL's.
fn has_gpu() -> bool {
    let nodes = fs::read_dir("/dev/dri").into_iter().flatten().flatten();
    nodes.into_iter().any(|node| node.file_name().to_string_lossy().starts_with("renderD"))
        || Path::new("/dev/nvidia0").exists()
        || Path::new("/dev/dxg").exists()
}

/// Shared libraries the dynamic linker can find by name.
struct Libraries(BTreeSet<String>);

impl Libraries {
    /// The linker's cache; where there is none (musl, `NixOS`) or it is stale, the usual folders.
    fn list() -> Self {
        let mut names = BTreeSet::new();
        for program in ["ldconfig", "/sbin/ldconfig"] {
            let Ok(output) = Command::new(program).arg("-p").stderr(Stdio::null()).output() else { continue };
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            names.extend(text.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned));
            break;
        }
        let extra = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let usual = ["/usr/lib", "/usr/lib64", "/usr/local/lib", "/lib", "/run/opengl-driver/lib"].map(PathBuf::from);
        for folder in env::split_paths(&extra).filter(|path| !path.as_os_str().is_empty()).chain(usual) {
            let entries = fs::read_dir(folder).into_iter().flatten().flatten();
            names.extend(entries.map(|entry| entry.file_name().to_string_lossy().into_owned()));
        }
        Self(names)
    }

    fn contains(&self, name: &str) -> bool {
        self.0.contains(name)
    }
}

/// Whether this process runs as root.
fn is_root() -> bool {
    let Ok(output) = Command::new("id").arg("-u").output() else { return false };
    output.stdout.trim_ascii() == b"0"
}

/// Installs Mesa's drivers with apt. What goes wrong is shown by apt itself; the caller looks for the driver again.
fn install_with_apt() {
    let install = {
        let mut arguments = vec!["install", "-y", "--no-install-recommends"];
        arguments.extend(DEBIAN_PACKAGES);
        arguments
    };
    for arguments in [vec!["update"], install] {
        let mut words = if is_root() { Vec::new() } else { vec!["sudo"] };
        words.push("apt-get");
        words.extend(arguments);
        eprintln!("Running `{}` ...", words.join(" "));
        // A package dialogue would wait for ever where nobody sits at the terminal. An update that fails (one source out of
        // reach) does not keep the install from succeeding.
        let status = Command::new(words[0]).args(&words[1..]).env("DEBIAN_FRONTEND", "noninteractive").status();
        match status {
            Ok(status) if status.success() => {}
            Ok(status) => eprintln!("`{}` ended with {status}.", words.join(" ")),
            Err(error) => eprintln!("`{}` could not be started: {error}.", words.join(" ")),
        }
    }
}

/// What to install by hand.
fn advice() -> String {
    format!(
        "Install Mesa's software Vulkan driver, or your GPU's own driver:\n  \
         Debian, Ubuntu   apt-get install {}\n  \
         Fedora, RHEL     dnf install mesa-vulkan-drivers vulkan-loader\n  \
         Arch             pacman -S vulkan-swrast vulkan-icd-loader\n  \
         Alpine           apk add mesa-vulkan-swrast vulkan-loader\n  \
         openSUSE         zypper install libvulkan_lvp libvulkan1\n  \
         NixOS            hardware.graphics.enable = true;",
        DEBIAN_PACKAGES.join(" ")
    )
}
