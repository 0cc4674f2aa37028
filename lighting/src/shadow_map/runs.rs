//! The lit runs of rays exactly as a shadow map shows them.

use glam::DVec3;
use gpu_backend::Host;

use super::{EMPTY, ShadowMap};
use crate::LightPath;
use crate::scene::raster::{Face, Rays};
use crate::scene::{Interval, Ray};
use crate::visibility::{LitInterval, VisibilitySource};

/// The lit parts of rays as a shadow map shows them: a walk from texel to texel, in
/// each of which the depth of the first blocker is one number.
///
/// The limit of a march through the same map as its steps become short, without
/// the steps: what no method that looks into this map can pass. Two lit parts that
/// touch are one.
///
/// Cost: `O(n)` for each ray and face of a map of `n` texels per side; in double
/// precision.
#[derive(Debug, Clone, Copy)]
pub struct TexelRuns<'a> {
    map: &'a ShadowMap<Host>,
}

impl<'a> TexelRuns<'a> {
    /// Walks this map, which must be that of the light that is gathered.
    pub fn new(map: &'a ShadowMap<Host>) -> Self {
        Self { map }
    }
}

impl VisibilitySource for TexelRuns<'_> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        let span = [f64::from(span.start), f64::from(span.end)];
        let first = lit.len();
        let mut runs = Runs { lit, first };
        let faces = self.map.faces();
        let views = faces.iter().map(|face| View::new(face, path.ray()));
        let mut seen: Vec<(usize, View, [f64; 2])> = views
            .enumerate()
            .filter_map(|(index, view)| Some((index, view, view.inside(span)?)))
            .collect();
        seen.sort_by(|a, b| a.2[0].total_cmp(&b.2[0]));
        let mut end = span[0];
        for (index, view, part) in seen {
            // What no face shows is lit.
            runs.push([end, part[0]]);
            self.walk(index, &view, part, &mut runs);
            end = part[1].max(end);
        }
        runs.push([end, span[1]]);
    }
}

impl TexelRuns<'_> {
    /// Walks through the texels of a face along a part of the ray that it shows.
    fn walk(&self, index: usize, view: &View, [start, end]: [f64; 2], runs: &mut Runs<'_>) {
        let side = self.map.resolution();
        let mut columns = Crossings::new(view.across, view.width, side, [start, end]);
        let mut rows = Crossings::new(-view.up, view.height, side, [start, end]);
        let side = side as usize;
        let texels = &self.map.depth()[index * side * side..][..side * side];
        let mut here = start;
        loop {
            let next = columns.next.min(rows.next).min(end).max(here);
            let depth = texels[rows.texel() * side + columns.texel()];
            if next > here {
                match depth {
                    EMPTY => runs.push([here, next]),
                    _ => runs.push(view.in_front(f64::from(depth), [here, next])),
                }
            }
            here = next;
            if here >= end {
                return;
            }
            if columns.next <= rows.next {
                columns.advance();
            } else {
                rows.advance();
            }
        }
    }
}

/// `a + b t` along a ray.
#[derive(Debug, Clone, Copy)]
struct Linear {
    a: f64,
    b: f64,
}

impl Linear {
    fn minus(self, scale: f64, other: Self) -> Self {
        Self {
            a: self.a - scale * other.a,
            b: self.b - scale * other.b,
        }
    }

    /// Its quotient with another at `t`, which may be infinite.
    fn over(self, other: Self, t: f64) -> f64 {
        match t.is_finite() {
            true => (self.a + self.b * t) / (other.a + other.b * t),
            false if other.b == 0.0 && self.b == 0.0 => self.a / other.a,
            false => self.b / other.b,
        }
    }

    /// The part of an interval in which it is not negative.
    fn positive(self, [start, end]: [f64; 2]) -> [f64; 2] {
        let zero = -self.a / self.b;
        if self.b > 0.0 {
            [start.max(zero), end]
        } else if self.b < 0.0 {
            [start, end.min(zero)]
        } else if self.a >= 0.0 {
            [start, end]
        } else {
            [end, start]
        }
    }
}

impl std::ops::Neg for Linear {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            a: -self.a,
            b: -self.b,
        }
    }
}

/// A ray as a face sees it.
#[derive(Debug, Clone, Copy)]
struct View {
    across: Linear,
    up: Linear,
    /// How far the picture reaches to either side, and up and down.
    width: Linear,
    height: Linear,
    depth: Depth,
}

/// How the depth of a point grows along a ray.
#[derive(Debug, Clone, Copy)]
enum Depth {
    Parallel(Linear),
    /// Distance from the light: where the ray passes it, and the square of how
    /// near.
    Central {
        foot: f64,
        square: f64,
    },
}

impl View {
    fn new(face: &Face, ray: &Ray) -> Self {
        let start = ray.origin().as_dvec3() - face.origin.as_dvec3();
        let direction = ray.direction().as_dvec3().normalize();
        let along = |axis: DVec3| Linear {
            a: start.dot(axis),
            b: direction.dot(axis),
        };
        let constant = |a: f32| Linear {
            a: f64::from(a),
            b: 0.0,
        };
        let forward = along(face.forward.as_dvec3());
        let (width, height, depth) = match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => (
                constant(half_width),
                constant(half_height),
                Depth::Parallel(forward),
            ),
            Rays::Central { tan } => {
                let reach = Linear { a: 0.0, b: 0.0 }.minus(-f64::from(tan), forward);
                let foot = -start.dot(direction);
                let square = (start + foot * direction).length_squared();
                (reach, reach, Depth::Central { foot, square })
            }
        };
        Self {
            across: along(face.right.as_dvec3()),
            up: along(face.up.as_dvec3()),
            width,
            height,
            depth,
        }
    }

    /// The part of an interval that the picture shows; `None` if that is nothing.
    fn inside(&self, mut part: [f64; 2]) -> Option<[f64; 2]> {
        for (position, reach) in [(self.across, self.width), (self.up, self.height)] {
            part = reach.minus(1.0, position).positive(part);
            part = reach.minus(-1.0, position).positive(part);
        }
        (part[0] < part[1]).then_some(part)
    }

    /// The part of an interval that is no deeper than `depth`; empty if its end is
    /// not after its start.
    fn in_front(&self, depth: f64, [start, end]: [f64; 2]) -> [f64; 2] {
        match self.depth {
            Depth::Parallel(forward) => {
                let room = Linear { a: depth, b: 0.0 }.minus(1.0, forward);
                room.positive([start, end])
            }
            Depth::Central { foot, square } => {
                let half = depth * depth - square;
                if half < 0.0 {
                    return [end, start];
                }
                let half = half.sqrt();
                [start.max(foot - half), end.min(foot + half)]
            }
        }
    }
}

/// Where a ray crosses from texel to texel in one direction.
#[derive(Debug)]
struct Crossings {
    position: Linear,
    reach: Linear,
    side: u32,
    /// The place at the end of the part.
    last: f64,
    /// +1 or −1: the way the ray takes.
    step: i64,
    /// The border that is crossed next.
    border: i64,
    /// The distance of that.
    next: f64,
}

impl Crossings {
    /// Those between the ends of a part that the picture shows.
    fn new(position: Linear, reach: Linear, side: u32, [start, end]: [f64; 2]) -> Self {
        let side_length = f64::from(side);
        // On the border of the picture it may lie outside by rounding.
        let place = |t: f64| {
            let place = 0.5 * side_length * (1.0 + position.over(reach, t));
            place.clamp(0.0, side_length)
        };
        let (first, last) = match (place(start), place(end)) {
            // At the light, through which the ray passes: all of it is in one texel.
            (first, last) if first.is_nan() => (last, last),
            (first, last) if last.is_nan() => (first, first),
            both => both,
        };
        let step = if last >= first { 1 } else { -1 };
        let border = match step {
            1 => first.floor() as i64 + 1,
            _ => first.ceil() as i64 - 1,
        };
        let mut new = Self {
            position,
            reach,
            side,
            last,
            step,
            border,
            next: 0.0,
        };
        new.next = new.distance();
        new
    }

    /// Where the ray meets the next border; infinite behind the last.
    fn distance(&self) -> f64 {
        let is_behind = match self.step {
            1 => self.border as f64 >= self.last,
            _ => self.border as f64 <= self.last,
        };
        if is_behind || !(1..i64::from(self.side)).contains(&self.border) {
            return f64::INFINITY;
        }
        let tangent = 2.0 * self.border as f64 / f64::from(self.side) - 1.0;
        let to = self.position.minus(tangent, self.reach);
        let distance = -to.a / to.b;
        // A ray along the border never crosses it.
        if distance.is_nan() {
            f64::INFINITY
        } else {
            distance
        }
    }

    fn advance(&mut self) {
        self.border += self.step;
        self.next = self.distance();
    }

    /// The texel before the next border.
    fn texel(&self) -> usize {
        let texel = match self.step {
            1 => self.border - 1,
            _ => self.border,
        };
        texel.clamp(0, i64::from(self.side) - 1) as usize
    }
}

/// Collects lit parts.
struct Runs<'a> {
    lit: &'a mut Vec<LitInterval>,
    /// Number of those of others before them.
    first: usize,
}

impl Runs<'_> {
    fn push(&mut self, [start, end]: [f64; 2]) {
        let (start, end) = (start as f32, end as f32);
        if !(start < end) {
            return;
        }
        if let Some(last) = self.lit[self.first..].last_mut()
            && last.interval.end >= start
        {
            last.interval.end = last.interval.end.max(end);
            return;
        }
        self.lit.push(LitInterval {
            interval: Interval::new(start, end),
            visibility: 1.0,
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};
    use gpu_backend::Cpu;

    use super::*;
    use crate::Emitter;
    use crate::scene::{Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
    use crate::shadow_map::{Casters, RenderShadowMap};

    /// Some slats above the ground, near the origin.
    fn slats() -> Geometry {
        let mut mesh = Mesh::default();
        for slat in 0..7_u32 {
            let x = slat as f32 - 3.3;
            let corners = [(0.0, -2.0), (0.45, -2.0), (0.45, 2.0), (0.0, 2.0)];
            let at = |(u, z): (f32, f32)| Vec3::new(x + u, 0.3 * u + 0.1 * x, z);
            mesh.positions.extend(corners.map(at));
            let first = 4 * slat;
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
        Geometry::new(&Scene::from(mesh)).unwrap()
    }

    fn lights() -> Vec<Emitter> {
        let point = |x: f32, y: f32, z: f32, emission| {
            Emitter::point(Vec3::new(x, y, z), Vec3::ONE, f32::INFINITY, emission).unwrap()
        };
        let cone = Cone {
            inner: 0.3,
            outer: 0.7,
        };
        let down = Quat::from_rotation_x(-1.4);
        vec![
            Emitter::directional(Vec3::new(0.3, -1.0, 0.2).normalize(), Vec3::ONE).unwrap(),
            // A cube, one face around all casters, and the face of a spotlight.
            point(0.1, 0.15, 0.3, Emission::Isotropic),
            point(2.0, 9.0, 1.0, Emission::Isotropic),
            point(0.2, 1.5, 0.4, Emission::spot(down, cone, None).unwrap()),
        ]
    }

    /// Rays in all directions from around the casters, some to the sky.
    fn rays() -> Vec<Ray> {
        let mut seed = 0x9e37_79b9_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let ray = |index: u32| {
            let origin = 8.0 * Vec3::new(random(), random(), random());
            let direction = Vec3::new(random(), random(), random());
            let length = if index % 4 == 0 { f32::INFINITY } else { 9.0 };
            Ray::new(origin, direction, length).unwrap()
        };
        (0..300).map(ray).collect()
    }

    #[test]
    fn runs_are_lit_where_the_map_says_so_and_nowhere_else() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &slats()).unwrap();
        let fog = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        for (number, light) in lights().iter().enumerate() {
            for side in [1, 7, 64] {
                let map = cpu.shadow_map(&casters, light, side).unwrap();
                let (mut asked, mut shadowed) = (0, 0);
                for ray in rays() {
                    let Some(path) = LightPath::new(&ray, light, &fog) else {
                        continue;
                    };
                    let mut lit = Vec::new();
                    TexelRuns::new(&map).lit_intervals(&path, &mut lit);
                    let ordered = |w: &[LitInterval]| w[0].interval.end < w[1].interval.start;
                    assert!(lit.windows(2).all(ordered), "{lit:?}");
                    let span = path.span();
                    let length = (span.end - span.start).min(20.0);
                    for i in 0..200 {
                        let t = span.start + length * (i as f32 + 0.37) / 200.0;
                        let at = |t: f32| map.is_lit(ray.at(t));
                        // Positions are rounded, in the map's lookup too.
                        let near = 2e-4;
                        if at(t - near) != at(t + near) || at(t) != at(t + near) {
                            continue;
                        }
                        let inside =
                            |part: &LitInterval| part.interval.start <= t && t <= part.interval.end;
                        assert_eq!(
                            lit.iter().any(inside),
                            at(t),
                            "light {number}, {side} texels, {ray:?} at {t}: {lit:?}"
                        );
                        asked += 1;
                        shadowed += usize::from(!at(t));
                    }
                }
                assert!(asked > 10_000, "light {number}: {asked}");
                assert!(side < 64 || shadowed > 300, "light {number}: {shadowed}");
            }
        }
    }

    #[test]
    fn a_ray_from_the_light_and_one_along_a_border_are_lit_up_to_the_caster() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &slats()).unwrap();
        let fog = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let [_, inside, ..] = &lights()[..] else {
            unreachable!("there are four");
        };
        let map = cpu.shadow_map(&casters, inside, 8).unwrap();
        let eye = Vec3::new(0.1, 0.15, 0.3);
        for direction in [Vec3::X, Vec3::ONE, Vec3::NEG_Y, Vec3::new(1.0, 1.0, 0.0)] {
            for origin in [eye, eye - 3.0 * direction] {
                let ray = Ray::new(origin, direction, f32::INFINITY).unwrap();
                let Some(path) = LightPath::new(&ray, inside, &fog) else {
                    continue;
                };
                let mut lit = Vec::new();
                TexelRuns::new(&map).lit_intervals(&path, &mut lit);
                for part in &lit {
                    assert!(part.interval.start >= 0.0 && part.interval.start < part.interval.end);
                }
            }
        }
    }
}
