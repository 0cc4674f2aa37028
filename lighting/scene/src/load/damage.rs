//! Damaged files for the tests of the readers.

use reference::random::Random;

/// Calls `read` with 4,000 copies of `file`, or as many as the environment
/// variable `DAMAGED_COPIES` says, each with up to four bytes replaced at places
/// and by values that are the same in every run.
pub(super) fn survives(file: &[u8], mut read: impl FnMut(&[u8])) {
    let mut random = Random::new(1);
    let mut next = |below: usize| random.below(below as u32) as usize;
    // Digits and the ends of integer ranges reach further than random bytes.
    const TELLING: &[u8] = b"\x00\x01\x7f\x80\xff09-.e{}[],\" \n";
    let copies = std::env::var("DAMAGED_COPIES");
    let copies = copies.ok().and_then(|copies| copies.parse().ok());
    for _ in 0..copies.unwrap_or(4000) {
        let mut damaged = file.to_vec();
        // A file that ends too early, now and then.
        if next(8) == 0 {
            damaged.truncate(next(file.len()) + 1);
        }
        for _ in 0..=next(4) {
            let value = match next(2) {
                0 => next(256) as u8,
                _ => TELLING[next(TELLING.len())],
            };
            let place = next(damaged.len());
            damaged[place] = value;
        }
        read(&damaged);
    }
}
