//! What makes a scene hard for a shadow map, in numbers.

use std::cmp::Ordering;
use std::fmt;

use glam::Vec3;
use gpu_backend::Cpu;

use super::topology::closed_components;
use crate::raster::{Face, Footprint, Rays};
use crate::{Bounds, Emitter, Geometry, Scene};

/// Largest light map that figures are taken from, texels per side: 200 MB.
pub const MAX_RESOLUTION: u32 = 4096;

/// Rows that are scanned as one unit of work.
const BAND: u32 = 8;

/// Largest half angle of the map of a light close to the scene: tan 75°.
const WIDEST_TAN: f32 = 3.732;

/// What makes a scene hard for a shadow map.
///
/// All but the first two figures are counted on a light map of `resolution`² texels, each of
/// which is a ray from the light through the texel's centre; all surfaces along the ray count.
/// The map of a sun is the tightest rectangle around the scene's box. A point light outside of
/// the box looks at the box's centre and sees all of the box, up to 75° to each side; one
/// inside of it looks at the centre through the 90° face of a cube. Cones, ranges and
/// translucent casters are ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Closed solids: connected components without a hole, of each instance.
    /// Components are told by shared position indices; where an edge has not
    /// exactly one opposite, the component is open and does not count.
    pub solids: u64,
    /// Triangles after instancing, without those that have no area.
    pub triangles: u64,
    /// Share of the texels of the light map in which there is any surface.
    pub covered_share: f64,
    /// Length of the silhouettes that the light sees: the number of texel
    /// edges, between texels that share a side, at which what is nearest to
    /// the light breaks off.
    ///
    /// In each covered texel the first solid is an interval of depths. It
    /// starts at the nearest front face and ends at the first depth from there
    /// on where as many back faces as front faces have been passed; where that
    /// never happens, because meshes are open, it is a single depth. An edge
    /// counts if the two intervals are disjoint, or if exactly one of the two
    /// texels is covered.
    pub silhouette_length: u64,
    /// Mean number of front faces behind a covered texel; 0 if none is
    /// covered.
    pub depth_complexity: f64,
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} solids, {} triangles; the light map is covered to {:.1} %, silhouettes are {} \
             texel edges long, {:.2} layers deep",
            self.solids,
            self.triangles,
            100.0 * self.covered_share,
            self.silhouette_length,
            self.depth_complexity
        )
    }
}

/// A light map that is empty or too large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("figures were asked for at {resolution} texels per side, expected 1 to {MAX_RESOLUTION}")]
pub struct ResolutionError {
    resolution: u32,
}

/// What a ray of the light map meets.
#[derive(Debug, Clone, Copy)]
struct Texel {
    /// The first solid; `enter` is infinite if there is none.
    enter: f32,
    exit: f32,
    front_faces: u32,
}

const NOTHING: Texel = Texel {
    enter: f32::INFINITY,
    exit: f32::INFINITY,
    front_faces: 0,
};

impl Texel {
    fn covered(&self) -> bool {
        self.enter < f32::INFINITY
    }

    /// True if a silhouette runs between two neighbours.
    fn breaks_off(&self, other: &Self) -> bool {
        match (self.covered(), other.covered()) {
            (true, true) => self.exit < other.enter || other.exit < self.enter,
            (a, b) => a != b,
        }
    }
}

/// One surface that a ray of the light map meets.
#[derive(Debug, Clone, Copy)]
struct Surface {
    texel: u32,
    depth: f32,
    front: bool,
    instance: u32,
}

impl Surface {
    /// By texel, then by depth; at one depth fronts first, so that a solid
    /// that touches the next one is joined with it.
    fn order(&self, other: &Self) -> Ordering {
        (self.texel.cmp(&other.texel))
            .then(self.depth.total_cmp(&other.depth))
            .then(other.front.cmp(&self.front))
            .then(self.instance.cmp(&other.instance))
    }

    /// True if this is `last` again: a ray through the common edge of two
    /// triangles of a mesh meets both, at depths that differ by rounding.
    fn repeats(&self, last: &Self) -> bool {
        (self.texel, self.front, self.instance) == (last.texel, last.front, last.instance)
            && self.depth - last.depth <= 4.0 * f32::EPSILON * self.depth
    }
}

/// The figures of a scene as `emitter` sees it, on a map of `resolution`²
/// texels. The result does not depend on the number of threads.
///
/// Takes O(triangles + texels × layers) time and 12 bytes per texel.
///
/// # Errors
/// [`ResolutionError`] if the resolution is 0 or above [`MAX_RESOLUTION`].
///
/// # Panics
/// If `geometry` was not made from `scene`.
pub fn figures(
    scene: &Scene,
    geometry: &Geometry,
    emitter: &Emitter,
    resolution: u32,
    cpu: &Cpu,
) -> Result<Figures, ResolutionError> {
    if !(1..=MAX_RESOLUTION).contains(&resolution) {
        return Err(ResolutionError { resolution });
    }
    let components = cpu.map(scene.meshes.len(), |mesh| {
        closed_components(&scene.meshes[mesh]) as u64
    });
    let solids = scene.instances.iter().map(|i| components[i.mesh]).sum();

    let face = face(geometry.bounds(), emitter);
    let map = light_map(cpu, &face, geometry, resolution);
    let covered = map.iter().filter(|texel| texel.covered()).count();
    let layers: u64 = map.iter().map(|texel| u64::from(texel.front_faces)).sum();
    Ok(Figures {
        solids,
        triangles: geometry.triangles().len() as u64,
        covered_share: covered as f64 / map.len() as f64,
        silhouette_length: silhouette_length(&map, resolution as usize),
        depth_complexity: layers as f64 / covered.max(1) as f64,
    })
}

/// The picture plane of the light map.
fn face(bounds: Bounds, emitter: &Emitter) -> Face {
    let (min, max) = (bounds.min(), bounds.max());
    let light = match emitter {
        Emitter::Directional(sun) => return Face::orthographic(bounds, sun.direction()),
        Emitter::Point(point) => point.position(),
    };
    let centre = 0.5 * (min + max);
    let forward = (centre - light).normalize_or(Vec3::NEG_Z);
    let right = forward.any_orthonormal_vector();
    let up = right.cross(forward);
    let tan = if bounds.contains(light) {
        1.0
    } else {
        let corner_tan = |corner: Vec3| {
            let v = corner - light;
            let across = v.dot(right).abs().max(v.dot(up).abs());
            // A corner beside the light or behind it is beyond any angle.
            across / v.dot(forward).max(1e-3 * across)
        };
        let widest = bounds
            .corners()
            .map(corner_tan)
            .into_iter()
            .fold(0.0, f32::max);
        widest.clamp(1e-6, WIDEST_TAN)
    };
    Face {
        origin: light,
        right,
        up,
        forward,
        rays: Rays::Central { tan },
    }
}

fn light_map(cpu: &Cpu, face: &Face, geometry: &Geometry, resolution: u32) -> Vec<Texel> {
    const CHUNK: usize = 4096;
    let triangles = geometry.triangles();
    let footprints: Vec<Vec<(Footprint, u32)>> =
        cpu.map(triangles.len().div_ceil(CHUNK), |chunk| {
            triangles[chunk * CHUNK..]
                .iter()
                .zip(&geometry.sources()[chunk * CHUNK..])
                .take(CHUNK)
                .filter_map(|(triangle, source)| {
                    Some((Footprint::new(face, triangle, resolution)?, source.instance))
                })
                .collect()
        });
    let mut bands = vec![Vec::new(); resolution.div_ceil(BAND) as usize];
    for footprint in footprints.iter().flatten() {
        let (first, end) = footprint.0.rows();
        for band in &mut bands[(first / BAND) as usize..end.div_ceil(BAND) as usize] {
            band.push(footprint);
        }
    }
    let width = resolution as usize;
    let mut map = vec![NOTHING; width * width];
    cpu.for_each_chunk(&mut map, BAND as usize * width, |first, texels| {
        let first_row = (first / width) as u32;
        let end_row = first_row + (texels.len() / width) as u32;
        let mut surfaces = Vec::new();
        for (footprint, instance) in &bands[(first_row / BAND) as usize] {
            footprint.for_each(first_row, end_row, |x, y, depth| {
                surfaces.push(Surface {
                    texel: (y - first_row) * resolution + x,
                    depth,
                    front: footprint.is_front(),
                    instance: *instance,
                });
            });
        }
        surfaces.sort_unstable_by(Surface::order);
        surfaces.dedup_by(|next, last| next.repeats(last));
        for run in surfaces.chunk_by(|l, r| l.texel == r.texel) {
            texels[run[0].texel as usize] = first_solid(run);
        }
    });
    map
}

/// The first solid among the surfaces of a texel, which come by depth.
fn first_solid(surfaces: &[Surface]) -> Texel {
    let front_faces = surfaces.iter().filter(|surface| surface.front).count() as u32;
    let first = surfaces.iter().position(|surface| surface.front);
    let rest = &surfaces[first.unwrap_or(0)..];
    let enter = rest[0].depth;
    let mut winding = 0;
    let exit = rest.iter().find_map(|surface| {
        winding += if surface.front { 1 } else { -1 };
        (winding == 0).then_some(surface.depth)
    });
    Texel {
        enter,
        exit: exit.unwrap_or(enter),
        front_faces,
    }
}

fn silhouette_length(map: &[Texel], width: usize) -> u64 {
    let breaks = |(a, b): (&Texel, &Texel)| u64::from(a.breaks_off(b));
    let beside: u64 = map
        .chunks_exact(width)
        .flat_map(|row| row.iter().zip(&row[1..]))
        .map(breaks)
        .sum();
    let below: u64 = map.iter().zip(&map[width..]).map(breaks).sum();
    beside + below
}

#[cfg(test)]
#[cfg(feature = "procedural")]
mod tests {
    use super::*;
    use crate::procedural::primitives::cuboid;
    use crate::{Emission, Instance, Mesh};

    fn scene(meshes: Vec<Mesh>) -> (Scene, Geometry) {
        let instance = |mesh| Instance {
            mesh,
            ..Instance::default()
        };
        let scene = Scene {
            instances: (0..meshes.len()).map(instance).collect(),
            meshes,
            ..Scene::default()
        };
        let geometry = Geometry::new(&scene).unwrap();
        (scene, geometry)
    }

    fn down(scene: &(Scene, Geometry), resolution: u32) -> Figures {
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        figures(&scene.0, &scene.1, &sun, resolution, &Cpu::new()).unwrap()
    }

    /// A slab of 8 × 8 m with a box of 2 × 2 m at the given height above it.
    fn box_over_slab(height: f32) -> (Scene, Geometry) {
        let slab = cuboid(Vec3::new(-4.0, -1.0, -4.0), Vec3::new(4.0, 0.0, 4.0));
        let corner = Vec3::new(-0.97, height, -0.97);
        scene(vec![
            slab,
            cuboid(corner, corner + Vec3::new(2.0, 1.0, 2.0)),
        ])
    }

    #[test]
    fn a_box_in_the_air_has_a_silhouette_and_one_that_touches_has_none() {
        let floating = down(&box_over_slab(0.5), 64);
        assert_eq!((floating.solids, floating.triangles), (2, 24));
        assert_eq!(floating.covered_share, 1.0);
        assert_eq!(floating.silhouette_length, 4 * 16);
        assert_eq!(floating.depth_complexity, 1.0 + 1.0 / 16.0);
        for sunk in [0.0, -0.5] {
            assert_eq!(down(&box_over_slab(sunk), 64).silhouette_length, 0);
        }
    }

    #[test]
    fn the_border_of_what_is_covered_is_a_silhouette() {
        let corner = Vec3::new(2.0, 0.0, 0.0);
        let scene = scene(vec![
            cuboid(Vec3::ZERO, Vec3::ONE),
            cuboid(corner, corner + Vec3::ONE),
        ]);
        let figures = down(&scene, 60);
        assert!((figures.covered_share - 2.0 / 3.0).abs() < 0.02);
        // The outer sides are the border of the picture.
        assert_eq!(figures.silhouette_length, 2 * 60);
    }

    #[test]
    fn an_open_mesh_is_no_solid_and_has_no_thickness() {
        let mut lid = cuboid(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 1.0, 1.0));
        lid.triangles.drain(0..6);
        let floor = cuboid(Vec3::new(-4.0, -1.0, -4.0), Vec3::new(4.0, 0.5, 4.0));
        let figures = down(&scene(vec![lid, floor]), 32);
        assert_eq!(figures.solids, 1);
        // A closed box would reach into the floor; the lid ends where it starts.
        assert_eq!(figures.silhouette_length, 4 * 8);
    }

    #[test]
    fn a_point_light_sees_all_of_the_box_from_wherever_it_is() {
        let scene = box_over_slab(0.5);
        for (position, least) in [
            (Vec3::new(0.0, 9.0, 0.0), 0.3),
            (Vec3::new(30.0, 20.0, -5.0), 0.1),
            (Vec3::new(0.3, 1.2, 0.2), 0.9),
            (Vec3::new(4.1, 0.2, 0.0), 0.05),
            (scene.1.bounds().max() * 1e3, 0.05),
        ] {
            let lamp =
                Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
            let lone = figures(&scene.0, &scene.1, &lamp, 64, &Cpu::single_threaded()).unwrap();
            let all = figures(&scene.0, &scene.1, &lamp, 64, &Cpu::new()).unwrap();
            assert_eq!(lone, all);
            assert!(lone.covered_share >= least, "{position}: {lone}");
        }
    }

    #[test]
    fn absurd_resolutions_are_refused() {
        let scene = box_over_slab(0.5);
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        for resolution in [0, MAX_RESOLUTION + 1, u32::MAX] {
            let error = figures(&scene.0, &scene.1, &sun, resolution, &Cpu::new()).unwrap_err();
            assert!(error.to_string().contains(&resolution.to_string()));
        }
        assert_eq!(down(&scene, 1).covered_share, 1.0);
    }
}
