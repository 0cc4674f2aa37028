//! Ray tracing of the triangles of a scene.
//!
//! The bounding volume hierarchy (BVH) comes from the library `obvhs`. The intersection tests
//! are implemented here, in f64, and are watertight: a ray through the common edge of two
//! triangles hits at least one of them.

mod build;
mod preorder;

use std::fmt;

use glam::{DVec3, Vec3};
use obvhs::bvh2::node::Bvh2Node;

use crate::{Caster, Coatings, Geometry, Ray, SceneError};

/// For the oracle of this workspace, which has boxes of its own.
#[doc(hidden)]
pub use build::hierarchy;
pub use preorder::{Preorder, PreorderNode};

/// The triangles of a scene, arranged for tracing.
#[derive(Clone)]
pub struct Tracer {
    nodes: Vec<Bvh2Node>,
    /// The triangles, in the order of the leaves.
    triangles: Vec<[Vec3; 3]>,
    /// Index into [`Geometry::triangles`] of each.
    indices: Vec<u32>,
    coatings: Coatings,
}

impl fmt::Debug for Tracer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tracer")
            .field("triangles", &self.triangles.len())
            .field("nodes", &self.nodes.len())
            .finish()
    }
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the origin of the ray, rounded towards it.
    pub distance: f32,
    /// Index into [`Geometry::triangles`].
    pub triangle: u32,
    /// Barycentric coordinate of the triangle's second corner.
    pub u: f32,
    /// Barycentric coordinate of the triangle's third corner.
    pub v: f32,
}

/// A surface that covers a part of what is behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pane {
    /// Where the ray meets it.
    pub hit: Hit,
    /// The share of the light from behind that passes, per colour channel.
    pub transmittance: Vec3,
}

impl Tracer {
    /// Builds the BVH, in O(n log n), or says that there is not enough memory.
    ///
    /// # Errors
    /// [`SceneError::OutOfMemory`].
    pub fn try_new(geometry: &Geometry) -> Result<Self, SceneError> {
        build::reserve("the hierarchy of triangles", geometry.triangles().len())?;
        Ok(Self::new(geometry))
    }

    /// Builds the BVH, in O(n log n).
    ///
    /// Where there is not enough memory, the allocator ends the program, as for any vector;
    /// [`Tracer::try_new`] returns an error.
    pub fn new(geometry: &Geometry) -> Self {
        let bvh = build::build(geometry.triangles());
        Self {
            triangles: bvh
                .primitive_indices
                .iter()
                .map(|&index| geometry.triangles()[index as usize])
                .collect(),
            indices: bvh.primitive_indices,
            nodes: bvh.nodes,
            coatings: geometry.coatings().clone(),
        }
    }

    /// What the triangles do to light that meets them.
    pub fn coatings(&self) -> &Coatings {
        &self.coatings
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.indices[..])
    }

    /// The first surface along the ray through which nothing can be seen. The ray passes
    /// through the holes of masks and through everything that lets a share of the light
    /// through, which [`Tracer::panes`] finds.
    ///
    /// Of several triangles at exactly the same distance, the one with the lowest index is
    /// reported.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let line = Line::new(ray.origin(), ray.direction());
        let mut best: Option<Hit> = None;
        self.visit(&line, 0.0, f64::from(ray.length()), |slot, far| {
            let Some((t, u, v)) = line.meets(&self.triangles[slot]) else {
                return far;
            };
            let triangle = self.indices[slot];
            let first = best.is_none_or(|hit| t < far || triangle < hit.triangle);
            if !(0.0 < t && t <= far && first) {
                return far;
            }
            match self.coatings.cover(triangle as usize) {
                Caster::Solid => {}
                cover if cover.transmittance_at(u, v) == Vec3::ZERO => {}
                _ => return far,
            }
            best = Some(Hit {
                distance: toward_zero(t),
                triangle,
                u: u as f32,
                v: v as f32,
            });
            t
        });
        best
    }

    /// The surfaces in front of the end of the ray that cover a share of what is behind them
    /// and let the rest of its light through, the nearest first. Surfaces that cast no shadow
    /// are included; holes and perfectly clear surfaces are not.
    ///
    /// A ray through a common edge of two triangles meets only one of them.
    pub fn panes(&self, ray: &Ray) -> Vec<Pane> {
        let mut panes = Vec::new();
        if !self.coatings.any_see_through() {
            return panes;
        }
        let line = Line::new(ray.origin(), ray.direction());
        let end = f64::from(ray.length());
        let mut edges = Edges::default();
        self.visit(&line, 0.0, end, |slot, far| {
            let triangle = self.indices[slot];
            if let Caster::SeeThrough(coating) = self.coatings.cover(triangle as usize)
                && let Some((t, u, v)) = line.meets(&self.triangles[slot])
                && 0.0 < t
                && t < end
                && edges.is_new(t, u, v)
            {
                let hit = Hit {
                    distance: toward_zero(t),
                    triangle,
                    u: u as f32,
                    v: v as f32,
                };
                let transmittance = coating.transmittance_at(u, v);
                if transmittance != Vec3::ZERO && coating.coverage(hit.u, hit.v) > 0.0 {
                    panes.push(Pane { hit, transmittance });
                }
            }
            far
        });
        panes.sort_unstable_by(|a, b| {
            let by_distance = a.hit.distance.total_cmp(&b.hit.distance);
            by_distance.then(a.hit.triangle.cmp(&b.hit.triangle))
        });
        panes
    }

    /// True if a triangle through which no light passes lies on `origin + t
    /// direction` for some `t` between `start` and `end`, both excluded. `end`
    /// may be infinite.
    pub fn occluded(&self, origin: Vec3, direction: Vec3, start: f32, end: f32) -> bool {
        let line = Line::new(origin, direction);
        let (start, end) = (f64::from(start), f64::from(end));
        let mut found = false;
        self.visit(&line, start, end, |slot, far| {
            found = line
                .meets(&self.triangles[slot])
                .is_some_and(|(t, u, v)| start < t && t < end && self.blocks(slot, u, v));
            if found { f64::NEG_INFINITY } else { far }
        });
        found
    }

    /// Whether no light passes at a point of the triangle in a slot.
    fn blocks(&self, slot: usize, u: f64, v: f64) -> bool {
        match self.coatings.caster(self.indices[slot] as usize) {
            Caster::Solid => true,
            Caster::Absent => false,
            caster => caster.transmittance_at(u, v) == Vec3::ZERO,
        }
    }

    /// The share of a lamp's light that passes all triangles between `start` and
    /// `end`, as for [`Tracer::occluded`], per colour channel: the product of
    /// their transmittances where the line meets them.
    ///
    /// A line through a common edge of two triangles meets one of them.
    pub fn transmittance(&self, origin: Vec3, direction: Vec3, start: f32, end: f32) -> Vec3 {
        if self.coatings.all_solid() {
            let is_dark = self.occluded(origin, direction, start, end);
            return if is_dark { Vec3::ZERO } else { Vec3::ONE };
        }
        self.product(origin, direction, start, end, |_| true)
    }

    /// The same for see-through triangles alone, as if no others existed. It serves callers
    /// that have the shadows of solid and masked triangles from elsewhere.
    pub fn transmittance_of_panes(
        &self,
        origin: Vec3,
        direction: Vec3,
        start: f32,
        end: f32,
    ) -> Vec3 {
        if !self.coatings.any_see_through() {
            return Vec3::ONE;
        }
        let is_pane = |caster: &Caster<'_>| matches!(caster, Caster::SeeThrough(_));
        self.product(origin, direction, start, end, is_pane)
    }

    fn product(
        &self,
        origin: Vec3,
        direction: Vec3,
        start: f32,
        end: f32,
        counts: impl Fn(&Caster<'_>) -> bool,
    ) -> Vec3 {
        let line = Line::new(origin, direction);
        let (start, end) = (f64::from(start), f64::from(end));
        let mut product = Vec3::ONE;
        let mut edges = Edges::default();
        self.visit(&line, start, end, |slot, far| {
            let caster = self.coatings.caster(self.indices[slot] as usize);
            if caster != Caster::Absent
                && counts(&caster)
                && let Some((t, u, v)) = line.meets(&self.triangles[slot])
                && start < t
                && t < end
            {
                let transmittance = caster.transmittance_at(u, v);
                if transmittance == Vec3::ZERO {
                    product = Vec3::ZERO;
                    return f64::NEG_INFINITY;
                }
                if edges.is_new(t, u, v) {
                    product *= transmittance;
                }
            }
            far
        });
        product
    }

    /// Calls `leaf(slot, far)` for the triangles whose boxes meet the line between `near` and
    /// `far`, near boxes first. `leaf` returns the new value of `far`; a value below `near`
    /// ends the visit.
    fn visit(&self, line: &Line, near: f64, mut far: f64, mut leaf: impl FnMut(usize, f64) -> f64) {
        let mut stack = Vec::with_capacity(64);
        let Some(root) = self.nodes.first() else {
            return;
        };
        if let Some(entry) = line.enters(root, near, far) {
            stack.push((0_usize, entry));
        }
        while let Some((index, entry)) = stack.pop() {
            if entry > far {
                continue;
            }
            let node = &self.nodes[index];
            let first = node.first_index as usize;
            if node.prim_count > 0 {
                for slot in first..first + node.prim_count as usize {
                    far = leaf(slot, far);
                    if far < near {
                        return;
                    }
                }
                continue;
            }
            let left = line.enters(&self.nodes[first], near, far);
            let right = line.enters(&self.nodes[first + 1], near, far);
            match (left, right) {
                (Some(l), Some(r)) if l <= r => {
                    stack.push((first + 1, r));
                    stack.push((first, l));
                }
                (Some(l), Some(r)) => {
                    stack.push((first, l));
                    stack.push((first + 1, r));
                }
                (Some(l), None) => stack.push((first, l)),
                (None, Some(r)) => stack.push((first + 1, r)),
                (None, None) => {}
            }
        }
    }

    /// Walks the BVH for shadows. `shadow_of_box` gives what a box, by its centre and half
    /// extent, could hide, if anything. `is_dark` tells whether all of that is already hidden,
    /// so that the box is skipped. `leaf` is called for the triangles of the other boxes, with
    /// their index in [`Geometry::triangles`], larger shadows first.
    pub fn walk<S: Copy + PartialOrd>(
        &self,
        shadow_of_box: impl Fn(DVec3, DVec3) -> Option<S>,
        is_dark: impl Fn(S) -> bool,
        mut leaf: impl FnMut(&[Vec3; 3], usize),
    ) {
        let enter = |index: usize| {
            let (min, max) = corners(&self.nodes[index]);
            shadow_of_box(0.5 * (min + max), 0.5 * (max - min))
        };
        let mut stack = Vec::with_capacity(64);
        if !self.nodes.is_empty()
            && let Some(shadow) = enter(0)
        {
            stack.push((0, shadow));
        }
        while let Some((index, shadow)) = stack.pop() {
            if is_dark(shadow) {
                continue;
            }
            let node = &self.nodes[index];
            let first = node.first_index as usize;
            if node.prim_count > 0 {
                let slots = first..first + node.prim_count as usize;
                for (triangle, &index) in self.triangles[slots.clone()]
                    .iter()
                    .zip(&self.indices[slots])
                {
                    leaf(triangle, index as usize);
                }
                continue;
            }
            match (enter(first), enter(first + 1)) {
                (Some(left), Some(right)) => {
                    let mut children = [(first, left), (first + 1, right)];
                    if left > right {
                        children.swap(0, 1);
                    }
                    stack.extend(children);
                }
                (Some(left), None) => stack.push((first, left)),
                (None, Some(right)) => stack.push((first + 1, right)),
                (None, None) => {}
            }
        }
    }
}

/// Positions at which a line passed through an edge of a triangle, so that an edge that two
/// triangles share counts once.
#[derive(Debug, Default)]
struct Edges(Vec<f64>);

impl Edges {
    /// Whether a hit is new, and not the same hit of a neighbouring triangle.
    fn is_new(&mut self, t: f64, u: f64, v: f64) -> bool {
        const ROUNDING: f64 = 1e-9;
        if u.min(v).min(1.0 - u - v) > ROUNDING {
            return true;
        }
        let is_known = self
            .0
            .iter()
            .any(|known| (known - t).abs() <= ROUNDING * t.abs());
        if !is_known {
            self.0.push(t);
        }
        !is_known
    }
}

/// The largest f32 that is not above a distance. A ray must end on the eye's side of what it
/// hits, so that no light leaks in from behind.
fn toward_zero(t: f64) -> f32 {
    let nearest = t as f32;
    if f64::from(nearest) > t {
        nearest.next_down()
    } else {
        nearest
    }
}

#[inline]
fn corners(node: &Bvh2Node) -> (DVec3, DVec3) {
    let vector = |v: glam::Vec3A| Vec3::from(v).as_dvec3();
    (vector(node.aabb.min), vector(node.aabb.max))
}

/// An infinite line, prepared for many tests in f64.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
}

impl Line {
    /// The line through `origin` along `direction`, which may have any length except 0.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let direction = direction.as_dvec3().normalize();
        Self {
            origin: origin.as_dvec3(),
            direction,
            inverse: direction.recip(),
        }
    }

    /// Where the line enters the box of `node`, if that is before `far` and
    /// it leaves after `near`.
    fn enters(&self, node: &Bvh2Node, near: f64, far: f64) -> Option<f64> {
        let (min, max) = corners(node);
        let (mut enter, mut leave) = (near, far);
        for axis in 0..3 {
            let a = (min[axis] - self.origin[axis]) * self.inverse[axis];
            let b = (max[axis] - self.origin[axis]) * self.inverse[axis];
            // 0 · ∞ = NaN means that the line runs within the face; it counts as inside.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        // Boxes are exact, but distances are rounded.
        let margin = 1e-12 * (enter.abs() + leave.abs().min(1e300));
        (enter <= leave + margin).then_some(enter - margin)
    }

    /// False only if the line, both ways, misses the box of the given centre
    /// and half extent.
    pub fn touches(&self, centre: DVec3, half: DVec3) -> bool {
        let offset = centre - self.origin;
        let along = offset.dot(self.direction);
        let reach = half.length();
        let miss2 = (offset - along * self.direction).length_squared();
        miss2 <= reach * reach * (1.0 + 1e-9) + 1e-18 * offset.length_squared()
    }

    /// Distance along the line (any sign) and barycentric coordinates of the
    /// second and third corner where it meets the triangle, edges included;
    /// `None` for a triangle that is seen edge-on.
    pub fn meets(&self, triangle: &[Vec3; 3]) -> Option<(f64, f64, f64)> {
        // The line meets the triangle where its direction (either way) is a
        // positive combination of the corners. The sign of each weight is that
        // of a determinant, and neighbours compute the same determinant for
        // their common edge with opposite sign: no gaps.
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3() - self.origin);
        let weight_a = self.direction.dot(b.cross(c));
        let weight_b = self.direction.dot(c.cross(a));
        let weight_c = self.direction.dot(a.cross(b));
        let all_positive = weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0;
        let all_negative = weight_a <= 0.0 && weight_b <= 0.0 && weight_c <= 0.0;
        if !(all_positive || all_negative) {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let across = normal.dot(self.direction);
        let sum = weight_a + weight_b + weight_c;
        if across == 0.0 || sum == 0.0 {
            return None;
        }
        let t = normal.dot(a) / across;
        t.is_finite().then_some((t, weight_b / sum, weight_c / sum))
    }
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::{AlphaMode, Filter, Instance, Material, Mesh, Sampler, Scene, Texture, Wrap};
    use glam::Vec2;

    fn geometry(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Geometry {
        let scene = Scene::from(Mesh {
            positions,
            triangles,
            ..Mesh::default()
        });
        Geometry::new(&scene).unwrap()
    }

    fn square() -> Geometry {
        let corner = |x: f32, y: f32| Vec3::new(x, y, -2.0);
        geometry(
            vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            vec![[0, 1, 2], [0, 2, 3]],
        )
    }

    #[test]
    fn a_square_is_hit_everywhere_and_only_there() {
        let geometry = square();
        let tracer = Tracer::new(&geometry);
        for i in 0..41 {
            for j in 0..41 {
                let (x, y) = (i as f32 * 0.06 - 1.2, j as f32 * 0.06 - 1.2);
                let ray = Ray::new(Vec3::ZERO, Vec3::new(x, y, -2.0), f32::INFINITY).unwrap();
                let hit = tracer.closest_hit(&ray);
                let inside = x.abs() <= 1.0 && y.abs() <= 1.0;
                assert_eq!(hit.is_some(), inside, "{x} {y}");
                let Some(hit) = hit else { continue };
                assert!((ray.at(hit.distance).z + 2.0).abs() < 1e-5);
                let [a, b, c] = geometry.triangles()[hit.triangle as usize];
                let point = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
                assert!((point - ray.at(hit.distance)).length() < 1e-5);
            }
        }
    }

    #[test]
    fn lengths_and_open_ends_are_respected() {
        let tracer = Tracer::new(&square());
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, 1.9).unwrap();
        assert_eq!(tracer.closest_hit(&ray), None);
        assert!(tracer.closest_hit(&ray.with_length(2.1)).is_some());
        let occluded = |start, end| tracer.occluded(Vec3::ZERO, Vec3::NEG_Z, start, end);
        assert!(occluded(0.0, f32::INFINITY));
        assert!(!occluded(0.0, 2.0) && !occluded(2.0, 3.0));
        assert!(occluded(1.0, 3.0));
    }

    #[test]
    fn the_hierarchy_finds_what_brute_force_finds() {
        let mut random = Random::new(1);
        let mut next = || random.unit() - 0.5;
        let mut vector = |scale: f32| Vec3::new(next(), next(), next()) * scale;
        let mut positions = Vec::new();
        for _ in 0..300 {
            let centre = vector(10.0);
            positions.extend([0; 3].map(|_| centre + vector(2.0)));
        }
        let triangles = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let geometry = geometry(positions, triangles);
        let tracer = Tracer::new(&geometry);
        for _ in 0..500 {
            let ray = Ray::new(vector(14.0), vector(1.0), f32::INFINITY).unwrap();
            let line = Line::new(ray.origin(), ray.direction());
            let expected = geometry
                .triangles()
                .iter()
                .filter_map(|triangle| line.meets(triangle))
                .map(|(t, _, _)| t)
                .filter(|&t| t > 0.0)
                .min_by(f64::total_cmp)
                .map(toward_zero);
            let found = tracer.closest_hit(&ray).map(|hit| hit.distance);
            assert_eq!(found, expected);
        }
    }

    /// The square of [`square`] and one at z = −4, of which the first is made of
    /// `material`.
    fn before_a_wall(material: Material) -> Geometry {
        let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        let mesh = |z: f32, material| Mesh {
            positions: vec![
                corner(-1.0, -1.0, z),
                corner(1.0, -1.0, z),
                corner(1.0, 1.0, z),
                corner(-1.0, 1.0, z),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            texture_coordinates: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
            material,
            ..Mesh::default()
        };
        let mut scene = Scene::from(mesh(-2.0, Some(0)));
        scene.meshes.push(mesh(-4.0, None));
        scene.instances.push(Instance {
            mesh: 1,
            ..Instance::default()
        });
        scene.materials.push(material);
        Geometry::new(&scene).unwrap()
    }

    fn along_z(x: f32, y: f32) -> Ray {
        Ray::new(Vec3::new(x, y, 0.0), Vec3::NEG_Z, f32::INFINITY).unwrap()
    }

    #[test]
    fn rays_pass_the_holes_of_a_mask() {
        // Opaque on the left half.
        let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
        let texture = texture.with_alpha(vec![1.0, 0.0]).unwrap();
        let geometry = before_a_wall(Material {
            base_color_texture: Some(texture.with_sampler(Sampler {
                wrap: [Wrap::Clamp; 2],
                filter: Filter::Linear,
            })),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        });
        let tracer = Tracer::new(&geometry);
        for (x, distance, is_dark) in [(-0.01, 2.0, true), (0.01, 4.0, false)] {
            for y in [-0.7, -0.01, 0.01, 0.4] {
                let hit = tracer.closest_hit(&along_z(x, y)).unwrap();
                assert_eq!(hit.distance, distance);
                let origin = Vec3::new(x, y, 0.0);
                assert_eq!(tracer.occluded(origin, Vec3::NEG_Z, 0.0, 3.0), is_dark);
                let share = tracer.transmittance(origin, Vec3::NEG_Z, 0.0, 3.0);
                assert_eq!(share, Vec3::splat(if is_dark { 0.0 } else { 1.0 }));
                assert!(tracer.panes(&along_z(x, y)).is_empty());
            }
        }
    }

    #[test]
    fn panes_are_seen_through_once_on_their_diagonal_too() {
        let geometry = before_a_wall(Material {
            opacity: 0.25,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        let tracer = Tracer::new(&geometry);
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (0.5, 0.2), (-0.3, 0.9)] {
            let ray = along_z(x, y);
            assert_eq!(tracer.closest_hit(&ray).unwrap().distance, 4.0);
            let panes = tracer.panes(&ray);
            assert_eq!(panes.len(), 1, "{x} {y}");
            assert_eq!(panes[0].hit.distance, 2.0);
            assert_eq!(panes[0].transmittance, Vec3::splat(0.75));
            let origin = Vec3::new(x, y, 0.0);
            let share = |end| tracer.transmittance(origin, Vec3::NEG_Z, 0.0, end);
            assert_eq!(share(3.0), Vec3::splat(0.75));
            assert_eq!(share(5.0), Vec3::ZERO);
            let glass = tracer.transmittance_of_panes(origin, Vec3::NEG_Z, 0.0, 5.0);
            assert_eq!(glass, Vec3::splat(0.75));
            assert!(!tracer.occluded(origin, Vec3::NEG_Z, 0.0, 3.0));
        }
    }

    #[test]
    fn clear_panes_are_as_if_they_were_not_there() {
        let geometry = before_a_wall(Material {
            opacity: 0.0,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        let tracer = Tracer::new(&geometry);
        let ray = along_z(0.2, 0.3);
        assert_eq!(tracer.closest_hit(&ray).unwrap().distance, 4.0);
        assert!(tracer.panes(&ray).is_empty());
        assert_eq!(
            tracer.transmittance(ray.origin(), Vec3::NEG_Z, 0.0, 3.0),
            Vec3::ONE
        );
    }
}
