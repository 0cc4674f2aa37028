//! How large a picture is compared: a rule of the scene, not of the clock.

use crate::parse::Size;

/// The largest number of times that a side is halved.
const MOST_HALVINGS: u32 = 2;

/// Units of work for which a second is set aside: a unit is one light of one pixel
/// of the reference in a scene of two triangles. Counted on two cores, so that the
/// reference and a round of all methods fit into half of the budget there.
const UNITS_PER_SECOND: f64 = 2.0e4;

/// The size of the picture of a comparison with so much time: the one asked for,
/// with both sides halved at most twice while the counted work of the scene does
/// not fit.
///
/// Nothing is measured, so every machine compares the same picture.
pub(crate) fn fitted(asked: Size, lights: usize, triangles: usize, seconds: f64) -> Size {
    let per_pixel = lights as f64 * (2.0 + triangles as f64).log2();
    let fits = |size: Size| size.pixels() as f64 * per_pixel <= UNITS_PER_SECOND * seconds;
    let mut size = asked;
    for _ in 0..MOST_HALVINGS {
        if fits(size) {
            break;
        }
        size = Size {
            width: (size.width / 2).max(1),
            height: (size.height / 2).max(1),
        };
    }
    size
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASKED: Size = Size {
        width: 480,
        height: 270,
    };

    #[test]
    fn pictures_are_halved_at_most_twice_and_keep_their_shape() {
        assert_eq!(fitted(ASKED, 1, 1000, 150.0), ASKED);
        let half = fitted(ASKED, 4, 1000, 150.0);
        assert_eq!((half.width, half.height), (240, 135));
        let quarter = fitted(ASKED, 1_000_000, 1_000_000, 1.0);
        assert_eq!((quarter.width, quarter.height), (120, 67));
        let one = Size {
            width: 1,
            height: 1,
        };
        assert_eq!(fitted(one, 1_000_000, 1, 1.0), one);
    }
}
