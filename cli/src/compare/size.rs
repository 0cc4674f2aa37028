//! How large a picture is compared: a rule of the scene, not of the clock.

use crate::parse::Size;

/// The largest number of times that a side is halved for the sake of methods, which can be
/// left out.
const MOST_HALVINGS: u32 = 2;

/// Units of work for which a second is set aside: a unit is one light of one pixel
/// of the reference in a scene of two triangles. Counted on two cores, so that the
/// reference and a round of all methods fit into half of the budget there.
const UNITS_PER_SECOND: f64 = 2.0e4;

/// How many parts of a ray behind hair and smoke are as much work as a ray without them.
const PARTS_PER_RAY: f64 = 12.0;

/// Share of the reference in the work if rays are not cut into parts: then its rays are less
/// work than those of all methods together.
const REFERENCE: f64 = 0.05;

/// The numbers of a scene on which its work depends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counted {
    pub(crate) lights: usize,
    /// Triangles, and pieces of strands and particles.
    pub(crate) casters: usize,
    /// The number of parts into which the reference cuts rays behind hair and smoke, if there
    /// are any.
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

    /// Units of work for a pixel of the reference.
    fn of_reference(self) -> f64 {
        let share = self.parts.map_or(REFERENCE, |_| 1.0);
        share * self.per_pixel()
    }
}

/// The size of the picture of a comparison that takes `seconds`: the one asked for, with both
/// sides halved at most twice while the counted work of the scene does not fit, and then as
/// often as it takes until the work of the reference fits. Methods for which there is no time
/// are left out, but without a reference there is nothing to be compared.
///
/// Nothing is measured, so every machine compares the same picture.
pub(crate) fn fitted(asked: Size, scene: Counted, seconds: f64) -> Size {
    let units = UNITS_PER_SECOND * seconds;
    let fits = |size: Size, per_pixel: f64| size.pixels() as f64 * per_pixel <= units;
    let mut size = asked;
    for halvings in 0.. {
        let is_small = halvings >= MOST_HALVINGS || fits(size, scene.per_pixel());
        if is_small && fits(size, scene.of_reference()) || size.pixels() == 1 {
            break;
        }
        size = size.halved();
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
    fn pictures_are_halved_at_most_twice_for_methods_and_keep_their_shape() {
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
        let quarter = fitted(ASKED, 165, 100_000, 150.0);
        assert_eq!((quarter.width, quarter.height), (120, 67));
        let one = Size {
            width: 1,
            height: 1,
        };
        assert_eq!(fitted(one, 1_000_000, 1, 1.0), one);
    }

    #[test]
    fn there_is_time_for_a_reference_in_any_scene() {
        for (casters, parts) in [
            (0, None),
            (0, Some(100)),
            (900_000, None),
            (0, Some(40_000)),
        ] {
            for lights in [1, 3, 165, 10_000] {
                let scene = Counted {
                    lights,
                    casters,
                    parts,
                };
                for seconds in [0.5, 14.0, 40.0, 150.0, 3600.0] {
                    let size = fitted(ASKED, scene, seconds);
                    let work = size.pixels() as f64 * scene.of_reference();
                    let fits = work <= UNITS_PER_SECOND * seconds;
                    assert!(fits || size.pixels() == 1, "{scene:?} {seconds}: {size}");
                    // A picture that is smaller than for the sake of methods has to be.
                    let is_small = size.width < ASKED.width / 4;
                    let larger = f64::from(2 * size.width + 1) * f64::from(2 * size.height + 1);
                    let would_fit = larger * scene.of_reference() <= UNITS_PER_SECOND * seconds;
                    assert!(!(is_small && would_fit), "{scene:?} {seconds}: {size}");
                }
            }
        }
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
