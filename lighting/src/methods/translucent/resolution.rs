//! How many texels the maps of casters need.

use glam::DVec3;
use transmittance::Packed;

use super::view::View;
use super::{Casters, Triangles};
use crate::scene::raster::{Face, Rays};
use crate::scene::{DensityGrid, Emitter, Interpolation, Translucent};

/// The largest memory of the maps of all lights together, bytes.
const MAX_BYTES: u64 = 1 << 29;

/// The largest memory of the map of one light, bytes.
const MAX_MAP_BYTES: u64 = 1 << 27;

/// The fewest texels per side of a face that sees something, and that of which others are a
/// multiple if they need fewer than they may have.
const FEWEST: u32 = 16;

/// The sides of a grid's box count as no edge up to this optical depth: that along its diagonal
/// if it were as dense all over as it is at most at these sides.
const FAINT: f64 = 0.02;

/// The largest growth of the optical depth over the width of a texel beside the outline of a
/// box. Interpolation is off by a quarter of it at the outline, and exact elsewhere.
const RISE: f64 = 0.08;

impl Casters<'_> {
    /// Texels per side of the finest face of a transmittance map of these casters for `emitter`,
    /// one of `emitters`, beside shadow maps of `map` texels: half of these, because a texel
    /// holds a curve. It is less
    ///
    /// - if the maps of all lights would take more than 512 MiB, or one of them more than
    ///   128 MiB, which is the limit of a binding in WebGPU;
    /// - if fewer texels show as much in [all faces](Casters::side).
    pub fn resolution(&self, map: u32, emitters: &[Emitter], emitter: &Emitter) -> u32 {
        let faces = |emitter: &Emitter| match emitter {
            Emitter::Directional(_) => 1,
            Emitter::Point(_) => 6,
        };
        let most = emitters.iter().map(faces).max().unwrap_or(0);
        let all: u64 = emitters.iter().map(faces).sum();
        let texel = self.channels() as u64 * size_of::<Packed<8>>() as u64;
        let bytes = |faces: u64, side: u32| texel * faces * u64::from(side) * u64::from(side);
        let mut side = (map / 2).max(1);
        while side > FEWEST && (bytes(all, side) > MAX_BYTES || bytes(most, side) > MAX_MAP_BYTES) {
            side /= 2;
        }
        let planes = self.planes(emitter);
        let sides = planes.iter().map(|face| self.side(face, side));
        sides.max().unwrap_or(1)
    }

    /// Texels per side that a face of a transmittance map of these casters
    /// [needs](super::TransmittanceMap::build_as_needed), at most `resolution`: one if it sees
    /// none of them, and a multiple of 16 if fewer show as much.
    ///
    /// - Where nothing but density grids casts shadows, whose samples are interpolated, no detail
    ///   of a shadow is smaller than their cells and mean free paths, and texels are not wider
    ///   than these.
    /// - Shadows also begin at the outlines of boxes that the smoke reaches. They do so gradually,
    ///   and texels are not wider than a rise of the optical depth by 0.08, unless the light
    ///   shines along a side of the box: then there is an edge. Around a lamp inside of a box
    ///   there is no outline.
    ///
    /// In tests with a cloud of 24³ samples, the share of light between texels is then off by up
    /// to 0.004 (root mean square).
    pub fn side(&self, face: &Face, resolution: u32) -> u32 {
        match self.needed(face, resolution) {
            0.0 => 1,
            // Casts saturate.
            needed => (needed.ceil() as u32)
                .max(1)
                .checked_next_multiple_of(FEWEST)
                .map_or(resolution, |side| side.min(resolution)),
        }
    }

    /// The number of texels of all faces of a map, in one colour.
    #[cfg(feature = "methods")]
    pub(crate) fn texels(&self, emitter: &Emitter, resolution: u32) -> u64 {
        let planes = self.planes(emitter);
        let sides = planes.iter().map(|face| self.side(face, resolution));
        sides.map(|side| u64::from(side).pow(2)).sum()
    }

    /// Texels per side beyond which a face shows no more: infinite if there are edges, 0 if it
    /// sees nothing.
    pub(super) fn needed(&self, face: &Face, resolution: u32) -> f64 {
        let view = View::new(face, resolution);
        let sees_triangles = match self.triangles {
            Triangles::None => false,
            Triangles::SeeThrough(geometry) if !geometry.coatings().any_see_through() => false,
            Triangles::SeeThrough(geometry) | Triangles::All(geometry) => {
                view.of_box(geometry.bounds()).is_some()
            }
        };
        if sees_triangles {
            return f64::INFINITY;
        }
        let of_caster = |caster: &Translucent| match (caster, caster.bounds()) {
            (_, Some(bounds)) if view.of_box(bounds).is_none() => 0.0,
            (_, None) => 0.0,
            (Translucent::Grid(grid), _) => detail(grid, face).max(detail_of_outline(grid, face)),
            (Translucent::Strands(_) | Translucent::Particles(_), _) => f64::INFINITY,
        };
        self.translucent.iter().map(of_caster).fold(0.0, f64::max)
    }
}

/// Extinction in 1/m of a grid where its density is 1, in the colour that it dims most.
fn sigma_t_of_density(grid: &DensityGrid) -> f64 {
    f64::from(grid.scale()) * f64::from(grid.tint().max_element())
}

/// The most cells or mean free paths of a grid across a face; infinite if cells have edges.
fn detail(grid: &DensityGrid, face: &Face) -> f64 {
    if grid.interpolation() == Interpolation::Constant {
        return f64::INFINITY;
    }
    let (_, cells_per_metre) = grid.cell_space();
    let cells = [0, 1, 2].map(|axis| cells_per_metre.row(axis).length());
    let sigma_t = sigma_t_of_density(grid) * f64::from(grid.max_density());
    let corners = grid.occupied_bounds().corners();
    let away = corners.map(|corner| corner.distance(face.origin));
    let farthest = away.into_iter().fold(0.0, f32::max);
    width(face, farthest.into()) * cells.into_iter().fold(sigma_t, f64::max)
}

/// The width of a face at a depth, m.
fn width(face: &Face, depth: f64) -> f64 {
    match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => 2.0 * f64::from(half_width.max(half_height)),
        Rays::Central { tan } => 2.0 * f64::from(tan) * depth,
    }
}

/// The most texels per side that a face needs for what begins at the outline of a grid's box;
/// infinite if a light shines along one of its sides, where the optical depth jumps.
///
/// An edge of the box is part of the outline if the light shines onto one of the two sides that
/// meet there and leaves through the other. Beside it the length of the light's way through the
/// box grows with the distance from the edge, by no more than the sum of 1 / sin of its angles
/// to both sides.
fn detail_of_outline(grid: &DensityGrid, face: &Face) -> f64 {
    let sigma_t = sigma_t_of_density(grid) * f64::from(grid.max_density_at_faces());
    let bounds = grid.bounds();
    let diagonal = f64::from(bounds.min().distance(bounds.max()));
    if sigma_t * diagonal <= FAINT {
        return 0.0;
    }
    let (corner, cells_per_metre) = grid.cell_space();
    let metres = cells_per_metre.inverse();
    let normals = [0, 1, 2].map(|axis| cells_per_metre.row(axis));
    let ends = grid.cells().map(|count| [0.0, f64::from(count)]);
    let forward = face.forward.as_dvec3();
    let light = grid.in_cells(face.origin.as_dvec3());
    // How far the light is in front of a side, or the sine of its angle to it, positive where
    // it enters.
    let before = |axis: usize, end: usize| {
        let outwards = [-1.0, 1.0][end] / normals[axis].length();
        match face.rays {
            Rays::Parallel { .. } => -outwards * normals[axis].dot(forward),
            Rays::Central { .. } => outwards * (light[axis] - ends[axis][end]),
        }
    };
    let mut most = 0.0_f64;
    for (axis, end_a, end_b) in edges() {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let heights = [before(a, end_a), before(b, end_b)];
        if heights[0] * heights[1] > 0.0 {
            continue;
        }
        let place = |along: f64| {
            let mut cells = DVec3::ZERO;
            (cells[axis], cells[a], cells[b]) = (along, ends[a][end_a], ends[b][end_b]);
            corner + metres * cells
        };
        let seen = clipped(face, ends[axis].map(place));
        let rise = |point: DVec3| {
            let offset = point - face.origin.as_dvec3();
            let length = match face.rays {
                Rays::Parallel { .. } => 1.0,
                Rays::Central { .. } => offset.length(),
            };
            let slopes = heights.map(|height| length / height.abs());
            width(face, offset.dot(forward)) * (slopes[0] + slopes[1])
        };
        most = seen.into_iter().flatten().map(rise).fold(most, f64::max);
    }
    sigma_t * most / RISE
}

/// The edges of a box: the axis along which an edge runs, and which of both sides of the next
/// and the last axis meet there.
fn edges() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..12).map(|edge| (edge / 4, edge & 1, edge >> 1 & 1))
}

/// The ends of what a face shows of a segment.
fn clipped(face: &Face, ends: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let (right, up, forward) = (face.right, face.up, face.forward);
    let axes = [right, up, forward].map(|axis| axis.as_dvec3());
    let local = ends.map(|end| axes.map(|axis| axis.dot(end - face.origin.as_dvec3())));
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in [0, 1] {
        for sign in [-1.0, 1.0] {
            // How far within the border.
            let within = local.map(|at| match face.rays {
                Rays::Parallel {
                    half_width,
                    half_height,
                } => f64::from([half_width, half_height][axis]) - sign * at[axis],
                Rays::Central { tan } => f64::from(tan) * at[2] - sign * at[axis],
            });
            match within.map(|at| at >= 0.0) {
                [true, true] => {}
                [false, false] => return None,
                [starts, _] => {
                    let share = within[0] / (within[0] - within[1]);
                    match starts {
                        true => to = to.min(share),
                        false => from = from.max(share),
                    }
                }
            }
        }
    }
    (from <= to).then(|| [from, to].map(|share| ends[0].lerp(ends[1], share)))
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3, Vec4};
    use gpu_backend::{Cpu, Host};
    use reference::random::Random;
    use transmittance::baseline::{Captured, Uncompressed};
    use transmittance::{CurveMap, Evaluate, Stream};

    use super::*;
    use crate::scene::{Bounds, Emission, Particle, Particles, Profile, StrandPoint, Strands};
    use crate::translucent::TransmittanceMap;

    const SAMPLES: u32 = 24;

    /// A cloud of two blobs, which has this density at the faces of its box.
    fn cloud(scale: f32, at_faces: f32, interpolation: Interpolation) -> DensityGrid {
        let bounds = Bounds::new(Vec3::splat(-1.0), Vec3::ONE).expect("a box");
        let blobs = [
            Vec4::new(0.2, 0.1, -0.1, 0.7),
            Vec4::new(-0.3, -0.3, 0.2, 0.6),
        ];
        let of = |at: u32| 2.0 * at as f32 / (SAMPLES - 1) as f32 - 1.0;
        let density = (0..SAMPLES.pow(3)).map(|i| {
            let place = Vec3::new(
                of(i % SAMPLES),
                of(i / SAMPLES % SAMPLES),
                of(i / SAMPLES.pow(2)),
            );
            let of_blob = |blob: &Vec4| {
                let near = (place.distance(blob.truncate()) / blob.w).min(1.0);
                (1.0 - near * near) * (1.0 - near * near)
            };
            blobs.iter().map(of_blob).sum::<f32>().max(at_faces)
        });
        let samples = [SAMPLES; 3];
        DensityGrid::new(bounds, samples, density.collect(), scale, interpolation).expect("a grid")
    }

    fn lights() -> [Emitter; 2] {
        let sun = Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE);
        [sun.expect("a sun"), lamp_at(Vec3::new(0.5, 3.0, -1.4))]
    }

    fn lamp_at(position: Vec3) -> Emitter {
        let lamp = Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
        lamp.expect("a lamp")
    }

    /// The share of the light of an emitter that a grid leaves, by its integral.
    fn arriving(grid: &DensityGrid, emitter: &Emitter, place: Vec3) -> f64 {
        let place = place.as_dvec3();
        let (direction, distance) = match emitter {
            Emitter::Directional(sun) => (-sun.direction().as_dvec3(), f64::INFINITY),
            Emitter::Point(point) => {
                let offset = point.position().as_dvec3() - place;
                (offset.normalize(), offset.length())
            }
        };
        let cells = grid.occupied_cells_along(place, direction, 0.0, distance);
        (-cells.map(|span| grid.optical_depth(&span)).sum::<f64>()).exp()
    }

    #[test]
    fn maps_of_smoke_without_edges_have_as_many_texels_as_it_has_details() {
        let cpu = Cpu::new();
        let cases = [(0.5, 0.0), (4.0, 0.0), (40.0, 0.0), (0.5, 0.2), (4.0, 0.02)];
        for (scale, at_faces) in cases {
            let grid = cloud(scale, at_faces, Interpolation::Linear);
            let smoke = [grid.clone().into()];
            let casters = Casters::new(&smoke, None);
            let [sun, lamp] = lights();
            for emitter in &[sun, lamp, lamp_at(Vec3::new(0.4, -0.2, 0.5))] {
                let few = casters.resolution(2048, &lights(), emitter);
                // A mean free path is 2 m over twice the scale.
                let expected = match (scale, at_faces) {
                    (0.5..=8.0, 0.0) => 32..=128,
                    _ => 32..=256,
                };
                assert!(expected.contains(&few), "{scale}, {at_faces}: {few}");
                let clear = Captured::new();
                let map: TransmittanceMap<Host, Uncompressed> =
                    TransmittanceMap::build_as_needed(&cpu, &casters, emitter, few, &clear)
                        .expect("a map");
                let (mut sum, mut count) = (0.0, 0.0);
                for i in 0..40_u32.pow(3) {
                    let place = Vec3::new(
                        (i % 40) as f32 - 19.3,
                        (i / 40 % 40) as f32 - 19.6,
                        (i / 1600) as f32 - 19.8,
                    );
                    let place = place / 20.0;
                    let off =
                        f64::from(map.transmittance(place).x) - arriving(&grid, emitter, place);
                    sum += off * off;
                    count += 1.0;
                }
                let rmse = (sum / count).sqrt();
                println!("{scale}, {at_faces}: {few} texels, {rmse:.1e}");
                assert!(rmse < 5e-3, "{scale}, {at_faces}, {few} texels: {rmse}");
            }
        }
    }

    #[test]
    fn maps_of_what_has_edges_are_as_large_as_memory_allows() {
        let particle = Particle {
            centre: Vec3::Y,
            radius: 0.5,
            sigma_t: 2.0,
        };
        let puffs = Particles::new(vec![particle], Profile::Constant).expect("particles");
        let edges: [Translucent; 2] = [
            cloud(1.0, 0.0, Interpolation::Constant).into(),
            puffs.into(),
        ];
        let smoke = Translucent::from(cloud(1.0, 0.0, Interpolation::Linear));
        for caster in edges {
            for casters in [vec![caster.clone()], vec![smoke.clone(), caster]] {
                let casters = Casters::new(&casters, None);
                for emitter in &lights() {
                    assert_eq!(casters.resolution(1024, &lights(), emitter), 512);
                    assert_eq!(casters.resolution(1, &lights(), emitter), 1);
                }
            }
        }
        // Along a face of its box smoke begins at once.
        let smoke = [cloud(1.0, 0.1, Interpolation::Linear).into()];
        let casters = Casters::new(&smoke, None);
        let noon = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun");
        for emitter in [noon, lamp_at(Vec3::new(0.5, 3.0, -1.0))] {
            assert_eq!(casters.resolution(1024, &lights(), &emitter), 512);
        }
        let nothing = Casters::new(&[], None);
        assert_eq!(nothing.resolution(1024, &lights(), &lights()[0]), 1);
    }

    fn ball(centre: Vec3) -> Translucent {
        let ball = Particle {
            centre,
            radius: 0.3,
            sigma_t: 1.0,
        };
        let balls = Particles::new(vec![ball], Profile::Soft);
        balls.expect("a particle").into()
    }

    #[test]
    fn faces_that_see_nothing_have_one_texel() {
        let cpu = Cpu::new();
        let mut random = Random::new(11);
        let mut single = 0;
        for round in 0..40 {
            let mut place = || Vec3::from(std::array::from_fn(|_| random.between(-2.0, 2.0)));
            let [position, centre, other] = [place(), place(), place()];
            let shift = Affine3A::from_translation(centre);
            let caster: Translucent = match round % 3 {
                0 => ball(centre),
                1 => {
                    let point = |position: Vec3| StrandPoint {
                        position,
                        thickness: 0.2,
                        opacity: 1.0,
                    };
                    let strand = vec![point(centre), point(centre + 0.4 * Vec3::Y)];
                    let strands = Strands::new(strand, vec![2]);
                    strands.expect("a strand").into()
                }
                _ => {
                    let grid = cloud(1.0, 0.0, Interpolation::Linear);
                    let small = shift * Affine3A::from_scale(Vec3::splat(0.3));
                    grid.with_transform(small).expect("a transform").into()
                }
            };
            // Around a lamp between two things there are six faces.
            let all = [caster, ball(other)];
            let casters = Casters::new(&all, None);
            let lamp = lamp_at(position);
            let clear = Stream::<8>::new();
            let map: TransmittanceMap =
                TransmittanceMap::build_as_needed(&cpu, &casters, &lamp, 64, &clear)
                    .expect("a map");
            let texels = map
                .curves()
                .iter()
                .map(|curves| curves.texels().len() as u64);
            assert_eq!(texels.sum::<u64>(), casters.texels(&lamp, 64));
            assert_eq!(map.bytes(), 64 * casters.texels(&lamp, 64));
            assert_eq!(
                map.sides().iter().max(),
                Some(&casters.resolution(128, &[], &lamp))
            );
            let faces = casters.faces(&cpu, &lamp, 64).expect("faces");
            for (&side, (face, blockers)) in map.sides().iter().zip(faces) {
                single += u32::from(side == 1);
                if side == 1 {
                    let curves: CurveMap<Packed<8>> =
                        CurveMap::build(&cpu, [64; 2], &clear, &blockers).expect("curves");
                    let end = |curve: &Packed<8>| curve.evaluate(f32::INFINITY)[0];
                    assert!(
                        curves.texels().iter().all(|curve| end(curve) == 1.0),
                        "{face:?}"
                    );
                }
            }
        }
        assert!(single > 40, "{single}");
    }
}
