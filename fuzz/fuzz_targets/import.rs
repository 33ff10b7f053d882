//! Any bytes as a model: an error or a scene whose indices and lengths hold, never a panic, a long wait or much memory.

#![no_main]

use libfuzzer_sys::fuzz_target;

mod shared;

fuzz_target!(|bytes: &[u8]| {
    shared::imported(bytes);
});
