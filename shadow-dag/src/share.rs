//! A bake shared out among processes.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::Error;

/// One of so many parts of a bake: `2/8` is the second of eight. All tiles of all
/// grids, in their order, are shared out in runs that are equal to a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Share {
    part: u32,
    parts: u32,
}

impl Default for Share {
    /// All of it.
    fn default() -> Self {
        Self { part: 1, parts: 1 }
    }
}

impl Share {
    /// Part `part`, from 1, of `parts`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `1 ≤ part ≤ parts`.
    pub fn new(part: u32, parts: u32) -> Result<Self, Error> {
        if parts == 0 {
            return Err(Error::bad_value("the number of parts", parts, "1 or more"));
        }
        if part == 0 || part > parts {
            return Err(Error::bad_value(
                "the part",
                part,
                "1 up to the number of parts",
            ));
        }
        Ok(Self { part, parts })
    }

    /// Which one, from 1.
    pub fn part(self) -> u32 {
        self.part
    }

    /// How many there are.
    pub fn parts(self) -> u32 {
        self.parts
    }

    /// Its run of `tiles`.
    pub(crate) fn of(self, tiles: usize) -> Range<usize> {
        let end = |part: u32| {
            let share = tiles as u128 * u128::from(part) / u128::from(self.parts);
            share as usize
        };
        end(self.part - 1)..end(self.part)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.parts)
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text:?} is no part, expected one such as 2/8");
        let (part, parts) = text.split_once('/').ok_or_else(expected)?;
        let number = |text: &str| text.trim().parse().map_err(|_| expected());
        Self::new(number(part)?, number(parts)?).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_runs_that_cover_everything_once() {
        for tiles in [0, 1, 7, 64, 4096 * 165] {
            for parts in [1, 2, 3, 8, 100] {
                let mut next = 0;
                for part in 1..=parts {
                    let run = Share::new(part, parts).unwrap().of(tiles);
                    assert_eq!(run.start, next);
                    let even = tiles / parts as usize;
                    assert!((even..=even + 1).contains(&run.len()));
                    next = run.end;
                }
                assert_eq!(next, tiles);
            }
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!("2/8".parse(), Ok(Share { part: 2, parts: 8 }));
        assert_eq!(Share::new(3, 4).unwrap().to_string(), "3/4");
        for text in [
            "",
            "1",
            "0/4",
            "5/4",
            "1/0",
            "-1/4",
            "a/b",
            "1/2/3",
            "1/99999999999",
        ] {
            assert!(text.parse::<Share>().is_err(), "{text}");
        }
    }
}
