//! Lights as a scene describes them.

use std::f64::consts::PI;

use glam::{DVec2, Quat, Vec3};

use super::{SceneError, Texture};
use crate::{Emission, Emitter, Falloff, Pattern};

/// A light of a scene. Algorithms see it as one or several [`Emitter`]s.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// Shines equally in all directions.
    Point(PointLight),
    /// Shines into a cone.
    Spot(SpotLight),
    /// Infinitely far away: the sun.
    Directional(DirectionalLight),
    /// A rectangle or a disk that glows on one side.
    Area(AreaLight),
}

/// A point that shines equally in all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLight {
    /// The name that selects it; may be empty.
    pub name: String,
    /// World position, m.
    pub position: Vec3,
    /// Radiant intensity, linear RGB.
    pub intensity: Vec3,
    /// Nothing farther away than this is lit, m; `f32::INFINITY` for no limit.
    pub range: f32,
    /// How the light falls off at its range.
    pub falloff: Falloff,
}

/// A point that shines into a cone around its local −Z.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotLight {
    /// The name that selects it; may be empty.
    pub name: String,
    /// World position, m.
    pub position: Vec3,
    /// From the light's space to the world's.
    pub rotation: Quat,
    /// Radiant intensity on the axis, linear RGB.
    pub intensity: Vec3,
    /// Nothing farther away than this is lit, m; `f32::INFINITY` for no limit.
    pub range: f32,
    /// How the light falls off at its range.
    pub falloff: Falloff,
    /// The cones in which the intensity is full and in which there is light at all.
    pub cone: Cone,
    /// A cookie (gobo) in front of the light that multiplies its intensity. It spans
    /// the square around the outer cone, upright with the light's local +Y.
    pub texture: Option<Texture>,
}

/// Half angles of a spotlight, radians.
///
/// At the angle θ to the axis the intensity is multiplied by
/// `clamp((cos θ − cos outer) / max(0.001, cos inner − cos outer), 0, 1)²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Up to here the intensity is full. 0 ≤ `inner` < `outer`.
    pub inner: f32,
    /// From here on it is 0. At most π/2.
    pub outer: f32,
}

/// Light from infinitely far away: parallel, or from a disk in the sky.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionalLight {
    /// The name that selects it; may be empty.
    pub name: String,
    /// The direction in which the light travels; a vector of any length except 0.
    pub direction: Vec3,
    /// Irradiance on a plane that faces the light, linear RGB.
    pub irradiance: Vec3,
    /// Angle that the disk spans in the sky, rad, from 0 (parallel light) to
    /// π/2. The sun spans 0.0093 seen from the Earth.
    pub angular_diameter: f32,
}

/// A rectangle or an ellipse that emits on the side of `edges[0] × edges[1]`;
/// seen from behind it is black.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaLight {
    /// The name that selects it; may be empty.
    pub name: String,
    /// The whole rectangle, or an ellipse in it.
    pub shape: AreaShape,
    /// The corner at texture coordinate (0, 0).
    pub corner: Vec3,
    /// The edges from that corner along the texture's u and v.
    pub edges: [Vec3; 2],
    /// Emitted radiance, linear RGB.
    pub radiance: Vec3,
    /// Multiplies the radiance over the rectangle.
    pub texture: Option<Texture>,
}

/// The outline of an [`AreaLight`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AreaShape {
    /// The rectangle of the two edges.
    #[default]
    Rectangle,
    /// The ellipse that touches the four sides of that rectangle.
    Disk,
}

/// White light of intensity 1 at the origin, without a limit.
impl Default for PointLight {
    fn default() -> Self {
        Self {
            name: String::new(),
            position: Vec3::ZERO,
            intensity: Vec3::ONE,
            range: f32::INFINITY,
            falloff: Falloff::Hard,
        }
    }
}

/// White light of intensity 1 at the origin along −Z, without a limit, in the
/// cone that glTF assumes: from 0 to π/4.
impl Default for SpotLight {
    fn default() -> Self {
        Self {
            name: String::new(),
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            intensity: Vec3::ONE,
            range: f32::INFINITY,
            falloff: Falloff::Hard,
            cone: Cone {
                inner: 0.0,
                outer: std::f32::consts::FRAC_PI_4,
            },
            texture: None,
        }
    }
}

/// Parallel white light of irradiance 1 along −Z.
impl Default for DirectionalLight {
    fn default() -> Self {
        Self {
            name: String::new(),
            direction: Vec3::NEG_Z,
            irradiance: Vec3::ONE,
            angular_diameter: 0.0,
        }
    }
}

/// A white square of side 1 and radiance 1 that faces +Z.
impl Default for AreaLight {
    fn default() -> Self {
        Self {
            name: String::new(),
            shape: AreaShape::Rectangle,
            corner: Vec3::new(-0.5, -0.5, 0.0),
            edges: [Vec3::X, Vec3::Y],
            radiance: Vec3::ONE,
            texture: None,
        }
    }
}

impl Light {
    /// What kind of light this is, for reports.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(spot) if spot.texture.is_some() => "textured spot",
            Self::Spot(_) => "spot",
            Self::Directional(_) => "directional",
            Self::Area(_) => "area",
        }
    }

    /// The name it is chosen by; empty if it has none.
    pub fn name(&self) -> &str {
        match self {
            Self::Point(light) => &light.name,
            Self::Spot(light) => &light.name,
            Self::Directional(light) => &light.name,
            Self::Area(light) => &light.name,
        }
    }

    /// The emitters that represent the light for algorithms: one, or `samples` of them for an
    /// area light or for a sun with a disk. There are at least 1 and at most 65536, the same in
    /// every run.
    ///
    /// **Rectangles** are represented by the points of a golden-ratio lattice: of n points the
    /// i-th lies at ((i + ½) / n, frac(½ + i (√5 − 1) / 2)) along the longer and the shorter
    /// edge. No two points have the same coordinate along an edge, so a penumbra whose edge is
    /// parallel to an edge of the light has n steps (with a regular grid it has √n). With 16
    /// points, the visible share of a light beyond a straight edge is off by at most 1/16 in
    /// that case (with a grid by 1/8), and by at most 1/7 for edges in other directions.
    /// **Disks** are represented by the points of Vogel's spiral: the i-th at the radius √((i +
    /// ½) / n) and the angle i times π (3 − √5). The disk of a sun is too, uniformly in solid
    /// angle.
    ///
    /// Each point has a cosine emission and the share 1/n of radiance × area, times the mean of
    /// the texture over a square of area 1/n around it. All are scaled so that their sum is the
    /// total emission of the light. They are in front of the light by 1e-3 of its shorter edge,
    /// so that a mesh in the same place does not hide them. [`AreaLight::virtual_lights`] has
    /// other patterns. The directions to a sun share the irradiance so that a plane that faces
    /// the middle of the disk receives all of it.
    /// # Errors
    /// [`SceneError::BadValue`] if a number is out of its domain.
    pub fn emitters(&self, samples: u32) -> Result<Vec<Emitter>, SceneError> {
        let samples = samples.clamp(1, 65536);
        match self {
            Self::Point(light) => {
                let emission = Emission::Isotropic;
                Emitter::point(light.position, light.intensity, light.range, emission)
                    .map(|e| vec![e.with_falloff(light.falloff)])
            }
            Self::Spot(light) => {
                let emission = Emission::spot(light.rotation, light.cone, light.texture.clone())?;
                Emitter::point(light.position, light.intensity, light.range, emission)
                    .map(|e| vec![e.with_falloff(light.falloff)])
            }
            Self::Directional(light) => light.emitters(samples),
            Self::Area(light) => light.virtual_lights(Pattern::Lattice, samples),
        }
    }
}

/// Vogel's spiral of `count` points in the unit disk.
pub(crate) fn spiral(count: u32) -> impl Iterator<Item = DVec2> {
    let step = PI * (3.0 - 5_f64.sqrt());
    (0..count).map(move |i| {
        let i = f64::from(i);
        ((i + 0.5) / f64::from(count)).sqrt() * DVec2::from_angle(i * step)
    })
}

impl DirectionalLight {
    fn emitters(&self, samples: u32) -> Result<Vec<Emitter>, SceneError> {
        let diameter = self.angular_diameter;
        if !(0.0..=std::f32::consts::FRAC_PI_2).contains(&diameter) {
            return Err(SceneError::bad_value(
                "directional light",
                "angular diameter",
                diameter,
                "0 to pi/2 rad",
            ));
        }
        if diameter == 0.0 || samples == 1 {
            return Emitter::directional(self.direction, self.irradiance).map(|e| vec![e]);
        }
        let Some(middle) = self.direction.try_normalize() else {
            // This returns the error for an invalid direction.
            return Emitter::directional(self.direction, self.irradiance).map(|e| vec![e]);
        };
        let middle = middle.as_dvec3();
        let (right, up) = middle.any_orthonormal_pair();
        // 1 − cos of the radius, without cancellation.
        let cap = 2.0 * (0.25 * f64::from(diameter)).sin().powi(2);
        let directions: Vec<_> = spiral(samples)
            .map(|p| {
                // The share of the cap within a cone is the square of the radius.
                let below = cap * p.length_squared();
                let sine = (below * (2.0 - below)).sqrt();
                let p = p.normalize_or_zero() * sine;
                (1.0 - below) * middle + p.x * right + p.y * up
            })
            .collect();
        let facing: f64 = directions.iter().map(|d| d.dot(middle)).sum();
        let share = (self.irradiance.as_dvec3() / facing).as_vec3();
        directions
            .into_iter()
            .map(|direction| Emitter::directional(direction.as_vec3(), share))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    fn panel(texture: Option<Texture>) -> AreaLight {
        AreaLight {
            corner: Vec3::new(-1.0, 2.0, 0.0),
            edges: [Vec3::X * 4.0, Vec3::Z],
            radiance: Vec3::new(3.0, 2.0, 1.0),
            texture,
            ..AreaLight::default()
        }
    }

    #[test]
    fn virtual_lights_share_the_power_of_the_rectangle() {
        let light = Light::Area(panel(None));
        for samples in [0, 1, 5, 16, 100] {
            let emitters = light.emitters(samples).unwrap();
            let total: Vec3 = emitters.iter().map(Emitter::intensity).sum();
            assert!((total - Vec3::new(12.0, 8.0, 4.0)).length() < 1e-4);
        }
        for samples in [1, 7, 16] {
            assert_eq!(light.emitters(samples).unwrap().len(), samples as usize);
        }
    }

    #[test]
    fn a_texture_is_shared_out_by_cell() {
        let texels = vec![Vec3::ZERO, Vec3::ZERO, Vec3::splat(2.0), Vec3::splat(2.0)];
        let texture = Texture::new(4, 1, texels).unwrap();
        let emitters = Light::Area(panel(Some(texture))).emitters(4).unwrap();
        let total: Vec3 = emitters.iter().map(Emitter::intensity).sum();
        assert!((total.x - 12.0).abs() < 0.1, "{total}");
        assert!(emitters[0].intensity().x < 0.1 * emitters[3].intensity().x);
    }

    /// Where the emitters of a square light of side 1 stand on it.
    fn places(samples: u32, shape: AreaShape) -> Vec<Vec2> {
        let light = Light::Area(AreaLight {
            shape,
            ..AreaLight::default()
        });
        let emitters = light.emitters(samples).unwrap();
        let place = |emitter: Emitter| match emitter {
            Emitter::Point(point) => {
                assert!((point.position().z - 1e-3).abs() < 1e-6, "in front");
                point.position().truncate()
            }
            Emitter::Directional(_) => panic!("an area light is near"),
        };
        emitters.into_iter().map(place).collect()
    }

    #[test]
    fn a_penumbra_is_off_by_one_of_sixteen_points_at_parallel_edges_and_by_less_than_three_at_others()
     {
        // The share of a square on one side of a line, over all lines, is the
        // light in a penumbra. A grid of 4 x 4 is off by two of its points at
        // lines parallel to a side.
        let places = places(16, AreaShape::Rectangle);
        for turn in (0..180).step_by(3) {
            let normal = DVec2::from_angle(f64::from(turn).to_radians());
            let parallel = turn % 90 == 0;
            for step in -70..70 {
                let offset = f64::from(step) / 100.0 + 1e-4;
                let behind = |p: DVec2| p.dot(normal) < offset;
                let found = places.iter().filter(|p| behind(p.as_dvec2())).count();
                let cells = (0..64 * 64).filter(|cell| {
                    let cell = DVec2::new(f64::from(cell % 64), f64::from(cell / 64));
                    behind((cell + 0.5) / 64.0 - 0.5)
                });
                let exact = cells.count() as f64 / 4096.0;
                let off = (found as f64 / 16.0 - exact).abs();
                // Half a column of the 64 is the error of the sum.
                let allowed = if parallel { 1.0 } else { 2.5 } / 16.0 + 0.5 / 64.0;
                assert!(off <= allowed, "{turn} {offset}: {off}");
            }
        }
    }

    #[test]
    fn no_two_points_of_a_rectangle_share_a_coordinate() {
        for samples in [2, 16, 100, 1000] {
            let places = places(samples, AreaShape::Rectangle);
            for axis in 0..2 {
                let mut all: Vec<f32> = places.iter().map(|p| p[axis]).collect();
                all.sort_by(f32::total_cmp);
                let gap = all.windows(2).map(|w| w[1] - w[0]).fold(1.0, f32::min);
                assert!(gap > 0.3 / samples as f32, "{samples}: {gap}");
                assert!(all[0] > -0.5 && all[all.len() - 1] < 0.5);
            }
        }
        assert_eq!(places(1, AreaShape::Rectangle), [Vec2::ZERO]);
    }

    #[test]
    fn points_of_a_disk_stay_in_it_and_fill_it_evenly() {
        let places = places(500, AreaShape::Disk);
        assert!(places.iter().all(|p| p.length() < 0.5));
        for share in [0.1, 0.25, 0.5, 0.9_f32] {
            let within = places.iter().filter(|p| p.length() < 0.5 * share.sqrt());
            let off = within.count() as f32 - share * 500.0;
            assert!(off.abs() <= 1.0, "{share}: {off}");
        }
        let centre: Vec2 = places.iter().sum::<Vec2>() / 500.0;
        assert!(centre.length() < 2e-3, "{centre}");
    }

    #[test]
    fn a_disk_emits_by_its_area() {
        let disk = Light::Area(AreaLight {
            shape: AreaShape::Disk,
            ..panel(None)
        });
        let total: Vec3 = disk
            .emitters(9)
            .unwrap()
            .iter()
            .map(Emitter::intensity)
            .sum();
        let expected = std::f32::consts::PI * Vec3::new(3.0, 2.0, 1.0);
        assert!((total - expected).length() < 1e-4, "{total}");
        let texture = Texture::new(1, 1, vec![Vec3::new(0.5, 0.0, 2.0)]).unwrap();
        let disk = Light::Area(AreaLight {
            shape: AreaShape::Disk,
            ..panel(Some(texture))
        });
        let total: Vec3 = disk
            .emitters(9)
            .unwrap()
            .iter()
            .map(Emitter::intensity)
            .sum();
        let expected = expected * Vec3::new(0.5, 0.0, 2.0);
        assert!((total - expected).length() < 1e-4, "{total}");
    }

    #[test]
    fn an_area_light_is_dark_behind() {
        for shape in [AreaShape::Rectangle, AreaShape::Disk] {
            let light = Light::Area(AreaLight {
                shape,
                ..AreaLight::default()
            });
            for emitter in light.emitters(16).unwrap() {
                let Emitter::Point(point) = emitter else {
                    panic!("an area light is near");
                };
                let behind = Vec3::new(0.3, -0.2, -1.0).normalize();
                assert_eq!(point.emission().factor(behind), Vec3::ZERO);
                assert!(point.emission().factor(-behind).x > 0.8);
            }
        }
    }

    #[test]
    fn a_sun_with_a_disk_is_as_many_directions_of_the_same_irradiance() {
        let sun = DirectionalLight {
            direction: Vec3::new(1.0, -2.0, 0.5),
            irradiance: Vec3::new(3.0, 2.0, 0.0),
            angular_diameter: 0.4,
            ..DirectionalLight::default()
        };
        let middle = sun.direction.normalize();
        let emitters = Light::Directional(sun.clone()).emitters(300).unwrap();
        assert_eq!(emitters.len(), 300);
        let (mut facing, mut mean, mut inner) = (Vec3::ZERO, Vec3::ZERO, 0);
        for emitter in &emitters {
            let Emitter::Directional(emitter) = emitter else {
                panic!("the sun is far away");
            };
            let angle = emitter.direction().angle_between(middle);
            assert!(angle < 0.2001, "{angle}");
            inner += u32::from(angle < 0.1);
            facing += emitter.irradiance() * emitter.direction().dot(middle);
            mean += emitter.direction() / 300.0;
        }
        assert!((facing - sun.irradiance).length() < 1e-4, "{facing}");
        assert!(mean.normalize().angle_between(middle) < 2e-3);
        // 1 − cos 0.1 is 0.2506 of 1 − cos 0.2.
        assert!(inner.abs_diff(75) <= 1, "{inner}");
        let emitters = Light::Directional(sun).emitters(1).unwrap();
        assert_eq!(emitters[0].intensity(), Vec3::new(3.0, 2.0, 0.0));
        let parallel = DirectionalLight::default();
        assert_eq!(Light::Directional(parallel).emitters(9).unwrap().len(), 1);
    }

    #[test]
    fn bad_lights_are_refused() {
        let point = PointLight::default();
        let cone = Cone {
            inner: 0.2,
            outer: 0.4,
        };
        let spot = SpotLight {
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            intensity: Vec3::ONE,
            range: 5.0,
            cone,
            ..SpotLight::default()
        };
        let bad = [
            Light::Point(PointLight {
                position: Vec3::new(0.0, f32::NAN, 0.0),
                ..point.clone()
            }),
            Light::Point(PointLight {
                intensity: Vec3::splat(-1.0),
                ..point.clone()
            }),
            Light::Point(PointLight {
                range: 0.0,
                ..point.clone()
            }),
            Light::Spot(SpotLight {
                cone: Cone { inner: 0.5, ..cone },
                ..spot.clone()
            }),
            Light::Spot(SpotLight {
                cone: Cone { outer: 2.0, ..cone },
                ..spot
            }),
            Light::Directional(DirectionalLight {
                direction: Vec3::ZERO,
                ..DirectionalLight::default()
            }),
            Light::Directional(DirectionalLight {
                direction: Vec3::ZERO,
                angular_diameter: 0.1,
                ..DirectionalLight::default()
            }),
            Light::Directional(DirectionalLight {
                angular_diameter: -0.1,
                ..DirectionalLight::default()
            }),
            Light::Directional(DirectionalLight {
                angular_diameter: f32::NAN,
                ..DirectionalLight::default()
            }),
            Light::Area(AreaLight {
                edges: [Vec3::X, Vec3::X],
                ..panel(None)
            }),
        ];
        for light in bad {
            assert!(light.emitters(4).is_err(), "{light:?}");
        }
    }
}
