//! See the function of this name in `tests/fuzz/targets`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| haarmonic_fuzz::merl_edits(data));
