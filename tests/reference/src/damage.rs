//! Damaged files: what readers have to survive.

use crate::random::Random;

/// A copy of `file` with up to four bytes replaced, and now and then cut off.
///
/// Half of the new bytes are digits, punctuation and the ends of integer ranges, which
/// reach further into a reader than random ones. An empty file stays empty.
pub fn damaged(file: &[u8], random: &mut Random) -> Vec<u8> {
    const TELLING: &[u8] = b"\x00\x01\x7f\x80\xff09-.e{}[],\" \n";
    let mut next = |below: usize| random.below(below as u32) as usize;
    let mut damaged = file.to_vec();
    if damaged.is_empty() {
        return damaged;
    }
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
    damaged
}

/// How many damaged copies a test tries: `usual`, or as many as the environment variable
/// `DAMAGED_COPIES` says.
pub fn copies(usual: usize) -> usize {
    let copies = std::env::var("DAMAGED_COPIES").ok();
    copies
        .and_then(|copies| copies.parse().ok())
        .unwrap_or(usual)
}

/// Calls `read` with 4,000 [damaged] copies of `file`, the same in every run, or with
/// [as many](copies) as the environment says.
pub fn survives(file: &[u8], mut read: impl FnMut(&[u8])) {
    let mut random = Random::new(1);
    for _ in 0..copies(4000) {
        read(&damaged(file, &mut random));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_differ_from_the_file_and_are_the_same_in_every_run() {
        let file: Vec<u8> = (0..100).collect();
        let copies = |seed| -> Vec<Vec<u8>> {
            let mut random = Random::new(seed);
            (0..100).map(|_| damaged(&file, &mut random)).collect()
        };
        let (first, again) = (copies(1), copies(1));
        assert_eq!(first, again);
        assert!(first.iter().any(|copy| copy.len() < 100));
        let whole = first.iter().filter(|copy| copy.len() == 100);
        let changed = whole.map(|copy| copy.iter().zip(0_u8..).filter(|(a, b)| **a != *b).count());
        assert!(changed.max() == Some(4));
        assert!(damaged(&[], &mut Random::new(1)).is_empty());
    }
}
