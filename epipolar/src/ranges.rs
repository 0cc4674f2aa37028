//! Dynamic range selection: the smallest box of epipolar space that holds what
//! a view can see.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013,
//! section 5, which asks for tight ranges and does not say how; the bounds here
//! are exact for α and θ of a pyramid, and for φ given the range of α.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use crate::cone::{Arc, angle_between};
use crate::light::Kind;
use crate::{Error, Space, ViewVolume};

/// Added at both ends of a range, in radians for α and θ and as a share of the largest φ,
/// because angles are computed with an error of 5e-7 rad.
const MARGIN: f64 = 1e-6;

/// Ranges are at least this wide, radians or share of the largest φ: f32 does
/// not resolve voxels in less.
const NARROWEST: f64 = 1e-5;

/// Intervals of the three coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranges {
    alpha: [f64; 2],
    theta: Arc,
    phi: [f64; 2],
}

impl Ranges {
    /// The ranges of what `view` sees in `space`; for a spotlight of what
    /// lies inside its cone as well.
    ///
    /// The bounds of α and θ are those of the pyramid, those of φ are taken at
    /// the near and far distances over all of that α; margins of 1e-6 are added
    /// for rounding and no range is narrower than 1e-5 (radians, or relative).
    ///
    /// # Errors
    /// [`Error::Unlit`] if the cone of a spotlight does not reach the ranges,
    /// [`Error::BadValue`] for a directional light in a view without a far end.
    pub fn new(space: &Space, view: &ViewVolume) -> Result<Self, Error> {
        let frame = space.frame64();
        let (mut alpha, mut theta) = match &view.pyramid {
            None => ([0.0, PI], Arc::Full),
            Some(pyramid) => (pyramid.angles(frame[0]), pyramid.around(frame)),
        };
        let mut phi = if space.is_directional() {
            distances(view, alpha)?
        } else {
            angles(f64::from(space.distance()), view, alpha)
        };
        if let Kind::Spot { axis, outer, .. } = space.light().0 {
            // A light ray is in the cone if its angle to the cone's axis, whose φ is `tilt`, is
            // at most `outer`. By the triangle inequality its φ differs by no more than that.
            let tilt = angle_between(axis, -frame[0]);
            phi = [phi[0].max(tilt - outer), phi[1].min(tilt + outer)];
            // A point that is seen along α lies on light rays with α + φ < π only, the angles
            // of a triangle.
            alpha[1] = alpha[1].min(PI - phi[0]);
            // If the line to the eye is outside of the cone and of its opposite, the cone lies
            // between two planes through that line. Where such a plane touches the cone, the
            // line, the axis and the point of contact are a spherical triangle with a right
            // angle: sin half = sin outer / sin tilt.
            if outer < tilt && tilt < PI - outer {
                let middle = DVec2::new(axis.dot(frame[1]), axis.dot(frame[2]));
                let cone = Arc::Part {
                    centre: middle.y.atan2(middle.x),
                    half: (outer.sin() / tilt.sin()).asin(),
                };
                theta = theta.intersection(cone).ok_or(Error::Unlit)?;
            }
            if !(phi[0] <= phi[1] && alpha[0] <= alpha[1]) {
                return Err(Error::Unlit);
            }
        }
        let highest = if space.is_directional() { f64::MAX } else { PI };
        Ok(Self {
            alpha: widened(alpha, 1.0, PI),
            theta: match theta {
                Arc::Full => Arc::Full,
                Arc::Part { centre, half } => {
                    let half = (half + MARGIN).max(0.5 * NARROWEST);
                    if half < PI {
                        Arc::Part { centre, half }
                    } else {
                        Arc::Full
                    }
                }
            },
            phi: widened(phi, phi[1].max(f64::from(f32::MIN_POSITIVE)), highest),
        })
    }

    /// Smallest and largest α, radians.
    pub fn alpha(&self) -> [f64; 2] {
        self.alpha
    }

    /// The middle of the range of θ, radians.
    pub fn theta_centre(&self) -> f64 {
        match self.theta {
            Arc::Full => 0.0,
            Arc::Part { centre, .. } => centre,
        }
    }

    /// The width of the range of θ, radians.
    pub fn theta_extent(&self) -> f64 {
        match self.theta {
            Arc::Full => 2.0 * PI,
            Arc::Part { half, .. } => 2.0 * half,
        }
    }

    /// Whether θ goes all the way around, so that its ends are neighbours: the
    /// light, or the point opposite to it, is in view.
    pub fn wraps(&self) -> bool {
        self.theta == Arc::Full
    }

    /// Smallest and largest φ in radians, or of the distance from the axis of
    /// a directional light in metres.
    pub fn phi(&self) -> [f64; 2] {
        self.phi
    }
}

/// The range with margins and at least the narrowest width, both times `unit`, within 0 and
/// `highest`.
fn widened([low, high]: [f64; 2], unit: f64, highest: f64) -> [f64; 2] {
    let low = (low - MARGIN * unit).max(0.0);
    let high = (high + MARGIN * unit).min(highest);
    let width = (high - low).max(NARROWEST * unit);
    let low = (0.5 * (low + high - width)).clamp(0.0, highest - width);
    [low, low + width]
}

/// φ of a point at the distance `x` from the eye on a ray with this α.
fn phi(eye_light: f64, x: f64, alpha: f64) -> f64 {
    if x == f64::INFINITY {
        return PI - alpha;
    }
    (x * alpha.sin()).atan2(eye_light - x * alpha.cos())
}

/// The range of φ of a point light.
///
/// Along a ray φ grows, so that the extremes are at the near and the far distance. At a fixed
/// distance x below D it has one maximum over α, asin(x/D) at cos α = x/D, so that its minimum
/// is at an end of the range of α; at distances beyond the light it falls with α.
fn angles(eye_light: f64, view: &ViewVolume, alpha: [f64; 2]) -> [f64; 2] {
    let at = |x, alpha| phi(eye_light, x, alpha);
    let low = if view.near < eye_light {
        at(view.near, alpha[0]).min(at(view.near, alpha[1]))
    } else {
        at(view.near, alpha[1])
    };
    let sine = view.far / eye_light;
    let highest = sine.min(1.0).acos();
    let high = if sine > 1.0 {
        at(view.far, alpha[0])
    } else if alpha[0] <= highest && highest <= alpha[1] {
        sine.asin()
    } else {
        at(view.far, alpha[0]).max(at(view.far, alpha[1]))
    };
    [low, high]
}

/// The range of the distance from the axis, x sin α, which has one maximum over α, at a right
/// angle.
fn distances(view: &ViewVolume, alpha: [f64; 2]) -> Result<[f64; 2], Error> {
    if view.far == f64::INFINITY {
        return Err(Error::bad_value(
            "the far bound of a view with a directional light",
            view.far,
            "a finite distance",
        ));
    }
    let [first, last] = alpha.map(f64::sin);
    let highest = if alpha[0] <= FRAC_PI_2 && FRAC_PI_2 <= alpha[1] {
        1.0
    } else {
        first.max(last)
    };
    Ok([
        view.near * first.min(last).max(0.0),
        view.far * highest.max(0.0),
    ])
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::prelude::*;

    use super::*;
    use crate::Light;

    fn view(near: f32, far: f32) -> ViewVolume {
        ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], near, far).unwrap()
    }

    fn ranges(light: Vec3, view: &ViewVolume) -> Ranges {
        let space = Space::new(Light::point(light).unwrap(), Vec3::ZERO).unwrap();
        Ranges::new(&space, view).unwrap()
    }

    #[test]
    fn a_light_in_view_sees_all_planes_and_starts_on_the_axis() {
        for light in [Vec3::new(0.5, 0.2, -5.0), Vec3::new(0.5, 0.2, 5.0)] {
            let found = ranges(light, &view(0.1, f32::INFINITY));
            assert!(found.wraps());
            assert_eq!(found.theta_extent(), 2.0 * PI);
            if light.z < 0.0 {
                assert_eq!(found.alpha()[0], 0.0);
                assert!((found.phi()[1] - PI).abs() < 1e-9);
            } else {
                assert_eq!(found.alpha()[1], PI);
            }
        }
    }

    #[test]
    fn a_light_off_screen_has_narrow_ranges() {
        let found = ranges(Vec3::new(0.0, 100.0, -20.0), &view(0.5, 20.0));
        assert!(!found.wraps());
        assert!(found.theta_extent() < 0.75 * PI);
        assert!(found.alpha()[0] > 0.3 && found.alpha()[1] < PI - 0.3);
        // 20 m of view seen from 100 m: asin(1/5).
        assert!(found.phi()[1] < 0.21);
    }

    #[test]
    fn ranges_of_almost_nothing_are_wide_enough_for_voxels() {
        let needle =
            ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [1e-7, 1e-7], 1.0, 1.000_001).unwrap();
        let found = ranges(Vec3::new(3.0, 0.0, -4.0), &needle);
        let width = |[low, high]: [f64; 2]| high - low;
        let least = 0.999 * NARROWEST;
        assert!(width(found.alpha()) >= least);
        assert!(found.theta_extent() >= least);
        assert!(width(found.phi()) >= least * found.phi()[1]);
    }

    #[test]
    fn a_spotlight_narrows_the_ranges_to_its_cone() {
        let at = Vec3::new(0.0, 4.0, -6.0);
        let spot = |along, outer| {
            let space = Space::new(Light::spot(at, along, outer).unwrap(), Vec3::ZERO).unwrap();
            Ranges::new(&space, &view(0.1, 30.0))
        };
        let wide = ranges(at, &view(0.1, 30.0));
        let narrow = spot(Vec3::NEG_Y, 0.1).unwrap();
        assert!(narrow.theta_extent() < 0.5 * wide.theta_extent());
        assert!((narrow.phi()[1] - narrow.phi()[0] - 0.2).abs() < 1e-4);
        // Away from the view.
        assert_eq!(spot(Vec3::Y, 0.1), Err(Error::Unlit));
        assert_eq!(spot(Vec3::NEG_Y, std::f32::consts::PI).unwrap(), wide);
    }

    #[test]
    fn a_sun_needs_a_far_end() {
        let sun = Light::directional(Vec3::new(0.2, -1.0, 0.1)).unwrap();
        let space = Space::new(sun, Vec3::ONE).unwrap();
        let found = Ranges::new(&space, &view(0.0, 50.0)).unwrap();
        assert_eq!(found.phi()[0], 0.0);
        assert!(found.phi()[1] <= 50.0 * (1.0 + 2e-6));
        let error = Ranges::new(&space, &view(0.0, f32::INFINITY)).unwrap_err();
        assert!(matches!(error, Error::BadValue { .. }), "{error}");
    }

    #[test]
    fn a_view_that_ends_at_the_light_sees_a_quarter_turn() {
        let found = ranges(Vec3::new(0.0, 0.0, -5.0), &view(0.0, 5.0));
        assert!((found.phi()[1] - FRAC_PI_2).abs() < 1e-5);
    }

    fn direction() -> impl Strategy<Value = Vec3> {
        [-1.0_f32..1.0, -1.0..1.0, -1.0..1.0]
            .prop_map(Vec3::from_array)
            .prop_filter("a direction", |v| v.length() > 0.1)
    }

    proptest! {
        #![proptest_config(reference::property::cases(2000))]
        #[test]
        fn every_visible_point_is_inside_and_the_bounds_are_reached(
            forward in direction(),
            up in direction(),
            tans in [0.02_f32..2.0, 0.02_f32..2.0],
            light in direction(),
            log_distance in -6.0_f32..6.0,
            log_near in -4.0_f32..2.0,
            log_depth in -2.0_f32..6.0,
            sun: bool,
        ) {
            prop_assume!(forward.normalize().cross(up.normalize()).length() > 0.1);
            let near = log_near.exp2();
            let far = near + log_depth.exp2();
            let view = ViewVolume::perspective(forward, up, tans, near, far).unwrap();
            let light = if sun {
                Light::directional(light).unwrap()
            } else {
                Light::point(light * log_distance.exp2()).unwrap()
            };
            let space = Space::new(light, Vec3::ZERO).unwrap();
            let found = Ranges::new(&space, &view).unwrap();
            let [axis, right, up_axis] = space.frame64();

            // All of the view, its edges and corners first.
            let forward = forward.as_dvec3().normalize();
            let side = forward.cross(up.as_dvec3()).normalize();
            let above = side.cross(forward);
            let steps = 24;
            let mut alpha = [PI, 0.0_f64];
            for i in 0..=steps {
                for j in 0..=steps {
                    let s = |k: i32| 2.0 * f64::from(k) / f64::from(steps) - 1.0;
                    let v = (forward
                        + s(i) * f64::from(tans[0]) * side
                        + s(j) * f64::from(tans[1]) * above)
                        .normalize();
                    let a = angle_between(axis, v);
                    alpha = [alpha[0].min(a), alpha[1].max(a)];
                    prop_assert!(found.alpha()[0] <= a && a <= found.alpha()[1]);
                    if !found.wraps() {
                        let t = v.dot(up_axis).atan2(v.dot(right)) - found.theta_centre();
                        let t = (t + PI).rem_euclid(2.0 * PI) - PI;
                        prop_assert!(2.0 * t.abs() <= found.theta_extent());
                    }
                    for x in [near, 0.5 * (near + far), far].map(f64::from) {
                        let value = if sun {
                            x * a.sin()
                        } else {
                            phi(f64::from(space.distance()), x, a)
                        };
                        prop_assert!(found.phi()[0] <= value && value <= found.phi()[1]);
                    }
                }
            }
            // A step of the samples is at most 2 × 2/24 of a tangent.
            let step = 2.0 / f64::from(steps) * f64::from(tans[0].hypot(tans[1]));
            prop_assert!(alpha[0] - found.alpha()[0] <= step);
            prop_assert!(found.alpha()[1] - alpha[1] <= step);
        }
    }
}
