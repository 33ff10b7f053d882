//! What an import allocates at most. A test binary of its own, as the allocator that counts is the whole program's.

mod common;

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use common::Model;
use murano_scene::{import, import_bytes};
use peak_alloc::PeakAlloc;
use serde_json::{Value, json};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Held while a test measures.
static MEASURING: Mutex<()> = Mutex::new(());

/// Bytes per byte of a model and of the files it refers to.
const FACTOR: u64 = 4;

/// Bytes that lists and tables begin with, however small the model.
const FLOOR: u64 = 16 << 10;

/// Most bytes held at a time while `run` runs, beyond those held before.
fn peak_of<T>(run: impl FnOnce() -> T) -> u64 {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    drop(run());
    (MEMORY.peak_usage() - before) as u64
}

/// The JSON of a model, null if it has none.
fn document(bytes: &[u8]) -> Value {
    let chunk = || {
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
        bytes.get(20..20 + length)
    };
    let json = if bytes.starts_with(b"glTF") { chunk() } else { Some(bytes) };
    serde_json::from_slice(json.unwrap_or_default()).unwrap_or_default()
}

fn list<'a>(document: &'a Value, name: &str) -> &'a [Value] {
    document[name].as_array().map_or(&[], Vec::as_slice)
}

/// Bytes of the files in `folder` that a document refers to.
fn referred_to(document: &Value, folder: &Path) -> u64 {
    let elements = list(document, "buffers").iter().chain(list(document, "images"));
    let files = elements.filter_map(|element| folder.join(element["uri"].as_str()?).metadata().ok());
    files.map(|file| file.len()).sum()
}

/// Bytes of the numbers that accessors legally ask for: those without a buffer view, which are zeros, and those of
/// which all bytes can be present.
fn asked_for(document: &Value, present: u64) -> u64 {
    let of_accessor = |accessor: &Value| {
        let components = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4" | "MAT2") => 4,
            Some("MAT3") => 9,
            _ => 16_u64,
        };
        let size = match accessor["componentType"].as_u64() {
            Some(5120 | 5121) => 1,
            Some(5122 | 5123) => 2,
            _ => 4,
        };
        let numbers = accessor["count"].as_u64().unwrap_or(0).saturating_mul(components);
        let legal = accessor["bufferView"].is_null() || numbers.saturating_mul(size) <= present;
        if legal { numbers.saturating_mul(4) } else { 0 }
    };
    list(document, "accessors").iter().map(of_accessor).fold(0, u64::saturating_add)
}

#[test]
fn malformed_files_take_no_more_than_they_hold() {
    let Some(folder) = common::data("malformed") else { return };
    let _alone = MEASURING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut largest = 0;
    for path in common::models(&folder) {
        let bytes = std::fs::read(&path).expect("readable");
        let document = document(&bytes);
        let present = bytes.len() as u64 + referred_to(&document, path.parent().expect("a folder"));
        let limit = (FACTOR * present + FLOOR).saturating_add(asked_for(&document, present));
        let peak = peak_of(|| import(&path));
        assert!(peak <= limit, "{}: {peak} bytes where {limit} are legal", path.display());
        largest = largest.max(peak);
    }
    eprintln!("at most {largest} bytes");
}

/// Places of all whole numbers in a document, as JSON pointers.
fn numbers(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(place.to_owned()),
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                numbers(item, &format!("{place}/{index}"), found);
            }
        }
        Value::Object(members) => {
            for (name, member) in members {
                numbers(member, &format!("{place}/{name}"), found);
            }
        }
        _ => {}
    }
}

#[test]
fn a_lie_in_any_number_takes_no_memory() {
    let model = Model::rich();
    let scene = model.import().expect("a sound model");
    assert!(scene.report.warnings.is_empty() && scene.report.extensions_ignored.is_empty(), "{:?}", scene.report);
    let mut places = Vec::new();
    numbers(&model.json, "", &mut places);
    let _alone = MEASURING.lock().unwrap_or_else(PoisonError::into_inner);
    for place in &places {
        for lie in [json!(0), json!(4), json!(1 << 16), json!(1 << 28), json!(1_u64 << 53), json!(u64::MAX), json!(-1)]
        {
            let mut lying = Model { json: model.json.clone(), bytes: model.bytes.clone() };
            *lying.json.pointer_mut(place).expect("it was found there") = lie.clone();
            let bytes = lying.glb();
            let present = bytes.len() as u64;
            let limit = FACTOR * present + FLOOR + asked_for(&lying.json, present);
            let peak = peak_of(|| import_bytes(&bytes, place));
            assert!(peak <= limit, "{place} = {lie}: {peak} bytes where {limit} are legal");
        }
    }
}
