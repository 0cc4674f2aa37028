//! Scattered light on surfaces for any light and any fog, with shadows in the fog.

use std::f32::consts::{FRAC_PI_2, PI};

use airlight::{Error, gauss};
use glam::Vec3;

use super::{Covers, NotCovered, SurfaceEvaluator};
use crate::airlight::far_end;
use crate::scene::{DirectionalEmitter, Emission, Emitter, Medium, PointEmitter, ScatteringAngle};
use crate::visibility::{PointVisibility, Share};

/// The light that fog scatters onto a surface, by quadrature over the fog.
///
/// For a point light, a point of the fog is given by the plane through light, surface and fog,
/// and by two angles in it: φ at the light and γ at the surface:
///
/// ```text
///                 X   fog
///               /   \
///          d  /       \  r
///           / φ      γ  \
///    light P ──────────── surface
///                 D
///
/// E = (σ_s / D) ∫∫∫ (n·ω) p(cos(φ + γ)) I V exp(−σ_t (d + r)) dγ dφ dψ,    φ + γ < π
/// d + r = D cos((γ − φ)/2) / cos((γ + φ)/2)
/// ```
///
/// where ψ is the angle of the plane around the line from light to surface. In these variables
/// both inverse squares and both solid angles cancel, and the integrand is bounded. The cone of
/// a spotlight, the hemisphere of the surface, the range, and the box of the medium are limits
/// of the integral instead of factors of the integrand, so that a narrow spotlight needs no
/// more nodes than a wide one. For a sun, the planes contain the direction to it, and the third
/// variable is the distance from the surface.
///
/// `V` comes from `points`: [`Unshadowed`](crate::visibility::Unshadowed), or a shadow map of
/// the light.
///
/// # Accuracy
///
/// With `n` nodes there are `2 n³` of them per light and surface. Without shadows, the largest
/// measured error relative to the brightest surface is
///
/// | nodes | 4 | 8 | 16 |
/// |---|---|---|---|
/// | even light, fog without bounds, g up to 0.6 | 1.4e-2 | 3e-4 | 4e-6 |
/// | spotlights, fog in a box | 8e-2 | 8e-3 | 3e-3 |
///
/// at optical depths up to 2 (`tests/benches/surface_light.rs` in the repository). The error grows with the
/// depth, and with |g| beyond 0.8. At the edge of a shadow it is about `1/n` of the light
/// there. All surfaces have the same nodes, so errors are smooth over the picture and not
/// noise.
///
/// The time grows with `n³`. With 8 nodes it is 100 to 240 times that of the closed form.
///
/// A surface at the place of the light receives 0.
#[derive(Debug, Clone)]
pub struct Quadrature<P> {
    points: P,
    rules: Rules,
}

/// Nodes and weights.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rules {
    /// A rule on (0, 1) for integrands that are steepest at 0, as pairs of node and weight.
    pub(super) line: Vec<[f32; 2]>,
    /// Planes all around, as cosine and sine of ψ, with equal weights.
    pub(super) circle: Vec<[f32; 2]>,
    /// Planes that touch an edge at ±1, as pairs of node and weight on (−1, 1).
    pub(super) arc: Vec<[f32; 2]>,
}

impl Rules {
    fn new(nodes: u32) -> Result<Self, Error> {
        let rule = gauss::Rule::new(nodes)?;
        let planes = 2 * nodes;
        let turn = |j: u32| (f64::from(j) + 0.5) / f64::from(planes);
        let narrow = |pair: [f64; 2]| pair.map(|value| value as f32);
        Ok(Self {
            // The substitution t = v².
            line: rule
                .iter()
                .map(|(v, weight)| narrow([v * v, 2.0 * v * weight]))
                .collect(),
            circle: (0..planes)
                .map(|j| (std::f64::consts::TAU * turn(j)).sin_cos())
                .map(|(sin, cos)| narrow([cos, sin]))
                .collect(),
            // The substitution ψ = ψ_max sin t, with midpoints of equal parts of t.
            arc: (0..planes)
                .map(|j| (std::f64::consts::PI * (turn(j) - 0.5)).sin_cos())
                .map(|(sin, cos)| narrow([sin, cos * std::f64::consts::PI / f64::from(planes)]))
                .collect(),
        })
    }
}

impl<P> Quadrature<P> {
    /// A rule with `nodes` nodes in two of the dimensions, and twice as many in the third.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 64 nodes.
    pub fn new(points: P, nodes: u32) -> Result<Self, Error> {
        if nodes > 64 {
            return Err(Error::BadValue {
                what: "the number of nodes",
                value: nodes.into(),
                expected: "1 to 64",
            });
        }
        Ok(Self {
            points,
            rules: Rules::new(nodes)?,
        })
    }

    /// The source of shadows in the fog.
    pub fn points(&self) -> &P {
        &self.points
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn rules(&self) -> &Rules {
        &self.rules
    }
}

/// Covers everything.
impl<P> Covers for Quadrature<P> {
    fn covers(&self, _: &Emitter, _: &Medium) -> Result<(), NotCovered> {
        Ok(())
    }
}

impl<P: PointVisibility> SurfaceEvaluator for Quadrature<P> {
    fn irradiance(&self, position: Vec3, normal: Vec3, emitter: &Emitter, medium: &Medium) -> Vec3 {
        match emitter {
            Emitter::Point(light) => self.of_point(position, normal, light, medium),
            Emitter::Directional(sun) => self.of_sun(position, normal, sun, medium),
        }
    }
}

impl<P: PointVisibility> Quadrature<P> {
    fn of_point(
        &self,
        position: Vec3,
        normal: Vec3,
        light: &PointEmitter,
        medium: &Medium,
    ) -> Vec3 {
        let to_light = light.position() - position;
        let distance = to_light.length();
        if distance == 0.0 {
            return Vec3::ZERO;
        }
        let toward = to_light / distance;
        let (axis, cos_edge) = match light.emission() {
            Emission::Isotropic => (normal, -1.0),
            Emission::Cosine { normal } => (*normal, 0.0),
            Emission::Spot(spot) => (spot.axis(), spot.cos_outer()),
        };
        let cone = Cone::new(axis, cos_edge, toward);
        let mut sum = Vec3::ZERO;
        self.for_each_plane(&cone, |side, plane_weight| {
            let surface = Facing::new(normal, toward, side);
            let (low, high) = surface.window();
            let (first, last) = cone.window(side);
            let last = last.min(PI - low);
            if !(first < last) {
                return;
            }
            for [t, weight] in &self.rules.line {
                let phi = first + (last - first) * t;
                let weight = plane_weight * weight * (last - first);
                let (sin_phi, cos_phi) = phi.sin_cos();
                let from_light = side * sin_phi - toward * cos_phi;
                let (entry, exit) = inside(medium, light.position(), from_light, light.range());
                // The angle at the surface of the point at this distance from the light.
                let seen = |d: f32| {
                    if d == f32::INFINITY {
                        PI - phi
                    } else {
                        (d * sin_phi).atan2(distance - d * cos_phi)
                    }
                };
                let start = low.max(seen(entry));
                let end = high.min(PI - phi).min(seen(exit));
                if !(start < end) {
                    continue;
                }
                let intensity = light.intensity() * light.emission().factor(from_light);
                let mut inner = Vec3::ZERO;
                for [t, weight] in &self.rules.line {
                    let gamma = start + (end - start) * t;
                    let (sin, cos) = gamma.sin_cos();
                    let half = 0.5 * (phi + gamma);
                    let (half_sin, half_cos) = (half.sin(), half.cos().max(0.0));
                    // sin(φ + γ), which equals the sine of the angle at the fog.
                    let apex = 2.0 * half_sin * half_cos;
                    let d = distance * (sin / apex);
                    let r = distance * (sin_phi / apex);
                    if !(d < f32::MAX && r < f32::MAX) {
                        continue;
                    }
                    let out = toward * cos + side * sin;
                    let point = position + r * out;
                    let share = self.points.visibility(point);
                    if share.is_dark() {
                        continue;
                    }
                    let length = match medium.bounds() {
                        None => distance * ((0.5 * (gamma - phi)).cos() / half_cos),
                        Some(_) => d - entry + medium.length_inside(position, out, r),
                    };
                    let angle = ScatteringAngle::from_half_tangent(half_sin, half_cos);
                    let scattered = weight * surface.cos(cos, sin) * medium.phase().value(angle);
                    let scattered = scattered * light.window_inside(d);
                    inner += share * (-medium.sigma_t() * length).exp() * scattered;
                }
                sum += intensity * inner * (weight * (end - start));
            }
        });
        medium.sigma_s() * sum / distance
    }

    fn of_sun(
        &self,
        position: Vec3,
        normal: Vec3,
        sun: &DirectionalEmitter,
        medium: &Medium,
    ) -> Vec3 {
        let toward = -sun.direction();
        let mut sum = Vec3::ZERO;
        self.for_each_plane(&Cone::new(normal, -1.0, toward), |side, plane_weight| {
            let surface = Facing::new(normal, toward, side);
            let (low, high) = surface.window();
            for [t, weight] in &self.rules.line {
                let gamma = low + (high - low) * t;
                let weight = plane_weight * weight * (high - low);
                let (sin, cos) = gamma.sin_cos();
                let out = toward * cos + side * sin;
                let (entry, exit) = inside(medium, position, out, f32::INFINITY);
                let exit = exit.min(entry + far_end(medium));
                if !(entry < exit) {
                    continue;
                }
                let mut inner = Vec3::ZERO;
                for [t, weight] in &self.rules.line {
                    let x = entry + (exit - entry) * t;
                    let point = position + x * out;
                    let share = self.points.visibility(point);
                    let leg = match medium.bounds() {
                        None => 0.0,
                        Some(_) => medium.length_inside(point, toward, f32::INFINITY),
                    };
                    let length = x - entry + leg;
                    inner += share * (-medium.sigma_t() * length).exp() * *weight;
                }
                let half = 0.5 * gamma;
                let angle = ScatteringAngle::from_half_tangent(half.sin(), half.cos().max(0.0));
                let scattered = surface.cos(cos, sin) * sin * medium.phase().value(angle);
                sum += inner * (weight * scattered * (exit - entry));
            }
        });
        medium.sigma_s() * sun.irradiance() * sum
    }

    /// Calls `plane` for planes all around, or as far as the cone reaches, with a weight and
    /// the unit vector in the plane that is perpendicular to the line from light to surface.
    fn for_each_plane(&self, cone: &Cone, mut plane: impl FnMut(Vec3, f32)) {
        match cone.half_turn {
            None => {
                let weight = 2.0 * PI / self.rules.circle.len() as f32;
                for [cos, sin] in &self.rules.circle {
                    plane(cone.middle * *cos + cone.across * *sin, weight);
                }
            }
            Some(half_turn) => {
                for [node, weight] in &self.rules.arc {
                    let (sin, cos) = (half_turn * node).sin_cos();
                    plane(cone.middle * cos + cone.across * sin, half_turn * weight);
                }
            }
        }
    }
}

/// The part of a line that lies in the medium and before `end`.
fn inside(medium: &Medium, start: Vec3, direction: Vec3, end: f32) -> (f32, f32) {
    let whole = crate::Interval::new(0.0, end);
    match medium.bounds() {
        None => (whole.start, whole.end),
        Some(bounds) => bounds
            .clip(start, direction, whole)
            .map_or((0.0, 0.0), |part| (part.start, part.end)),
    }
}

/// The directions of a light within `u·axis ≥ cos_edge`, in terms of the line to the surface.
struct Cone {
    /// Perpendicular to the line: a vector in the plane that contains the axis, and one
    /// perpendicular to that plane.
    middle: Vec3,
    across: Vec3,
    /// The planes that meet the cone are within this angle of the middle one; `None` if all
    /// planes meet it.
    half_turn: Option<f32>,
    axis: Vec3,
    cos_edge: f32,
    /// Cosine between the axis and the direction to the surface.
    cos_axis: f32,
}

impl Cone {
    /// `toward` is the direction from the surface to the light. `cos_edge` is −1 or at least 0.
    fn new(axis: Vec3, cos_edge: f32, toward: Vec3) -> Self {
        let cos_axis = -axis.dot(toward);
        let offset = axis + cos_axis * toward;
        let middle = if offset.length_squared() > 1e-12 {
            offset.normalize()
        } else {
            toward.any_orthonormal_vector()
        };
        // In the plane at ψ the axis has the components cos_axis and cos ψ sin_axis.
        let sin2_axis = (1.0 - cos_axis) * (1.0 + cos_axis);
        let half_turn = (cos_axis.abs() < cos_edge).then(|| {
            let rest = (cos_edge - cos_axis) * (cos_edge + cos_axis);
            // atan2 of the sine and the cosine of ψ_max, where cos ψ_max is √(rest / sin²).
            (sin2_axis - rest).max(0.0).sqrt().atan2(rest.sqrt())
        });
        Self {
            middle,
            across: toward.cross(middle),
            half_turn,
            axis,
            cos_edge,
            cos_axis,
        }
    }

    /// The angles φ at the light, measured from the direction to the surface towards `side`,
    /// that are in the cone.
    fn window(&self, side: Vec3) -> (f32, f32) {
        if self.cos_edge < 0.0 {
            return (0.0, PI);
        }
        let across = self.axis.dot(side);
        let reach = self.cos_axis.hypot(across);
        if reach <= self.cos_edge {
            return (0.0, 0.0);
        }
        let half = ((reach - self.cos_edge) * (reach + self.cos_edge))
            .sqrt()
            .atan2(self.cos_edge);
        window(across.atan2(self.cos_axis), half)
    }
}

/// The orientation of a surface relative to a plane through the light.
struct Facing {
    /// Components of the normal towards the light and towards the side.
    along: f32,
    across: f32,
}

impl Facing {
    fn new(normal: Vec3, toward: Vec3, side: Vec3) -> Self {
        Self {
            along: normal.dot(toward),
            across: normal.dot(side),
        }
    }

    /// The angles γ, measured from the light towards the side, that are in front of the
    /// surface.
    fn window(&self) -> (f32, f32) {
        window(self.across.atan2(self.along), FRAC_PI_2)
    }

    fn cos(&self, cos: f32, sin: f32) -> f32 {
        (self.along * cos + self.across * sin).max(0.0)
    }
}

/// The part of [0, π] within `half` ≤ π/2 of the direction `middle` in (−π, π]; it is a single
/// interval.
fn window(middle: f32, half: f32) -> (f32, f32) {
    if middle + half > 0.0 {
        ((middle - half).max(0.0), (middle + half).min(PI))
    } else {
        (middle - half + 2.0 * PI, PI)
    }
}
