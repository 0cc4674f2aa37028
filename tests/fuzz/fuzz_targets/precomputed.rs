#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("precomputed"),
    |data: &[u8]| crepuscular_fuzz::precomputed::run(data)
);
