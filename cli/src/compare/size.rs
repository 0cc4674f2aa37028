//! How large a picture is compared: a rule of the scene, not of the clock.

use crate::parse::Size;

/// The largest number of times that a side is halved.
const MOST_HALVINGS: u32 = 2;

/// Units of work for which a second is set aside: a unit is one light of one pixel
/// of the reference in a scene of two triangles. Counted on two cores, so that the
/// reference and a round of all methods fit into half of the budget there.
const UNITS_PER_SECOND: f64 = 2.0e4;

/// Parts of a ray behind hair and smoke that are as much work as a ray without them.
const PARTS_PER_RAY: f64 = 12.0;

/// What is counted of a scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counted {
    pub(crate) lights: usize,
    /// Triangles, and pieces of strands and particles.
    pub(crate) casters: usize,
    /// Parts that the reference cuts rays into behind hair and smoke, if there are any.
    pub(crate) parts: Option<u32>,
}

impl Counted {
    /// Units of work for a pixel.
    pub(crate) fn per_pixel(self) -> f64 {
        let parts = self
            .parts
            .map_or(1.0, |parts| f64::from(parts) / PARTS_PER_RAY);
        self.lights as f64 * (2.0 + self.casters as f64).log2() * parts.max(1.0)
    }
}

/// The size of the picture of a comparison with so much time: the one asked for,
/// with both sides halved at most twice while the counted work of the scene does
/// not fit.
///
/// Nothing is measured, so every machine compares the same picture.
pub(crate) fn fitted(asked: Size, scene: Counted, seconds: f64) -> Size {
    let per_pixel = scene.per_pixel();
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
        let fitted = |asked, lights, casters, seconds| {
            let parts = None;
            let scene = Counted {
                lights,
                casters,
                parts,
            };
            fitted(asked, scene, seconds)
        };
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

    #[test]
    fn parts_behind_hair_and_smoke_are_work() {
        let quick = Size {
            width: 160,
            height: 90,
        };
        let scene = |casters: usize, parts: Option<u32>| Counted {
            lights: 1,
            casters,
            parts,
        };
        assert_eq!(fitted(quick, scene(20_000, None), 14.0), quick);
        assert_eq!(fitted(quick, scene(20_000, Some(48)), 14.0).width, 80);
        // One grid of smoke is one caster.
        assert_eq!(fitted(quick, scene(1, Some(48)), 14.0), quick);
    }
}
