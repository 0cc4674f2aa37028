//! How many texels the maps of casters need.

use transmittance::Packed;

use super::{Casters, Triangles};
use crate::scene::raster::Rays;
use crate::scene::{DensityGrid, Emitter, Interpolation, Translucent};
use crate::shadow_map::faces;

/// The largest memory of the maps of all lights together, bytes.
const MAX_BYTES: u64 = 1 << 29;

/// The largest memory of the map of one light, bytes.
const MAX_MAP_BYTES: u64 = 1 << 27;

/// The faces of a grid's box count as no edge up to this optical depth: that along its diagonal
/// if it were as dense all over as it is at most at these faces.
const FAINT: f64 = 0.02;

impl Casters<'_> {
    /// Texels per side of the faces of a transmittance map of these casters for `emitter`, one
    /// of `emitters`, beside shadow maps of `map` texels: half of these, because a texel holds a
    /// curve. It is less
    ///
    /// - if the maps of all lights would take more than 512 MiB, or one of them more than
    ///   128 MiB, which is the limit of a binding in WebGPU;
    /// - if fewer texels show as much: where nothing but density grids casts shadows, and these
    ///   fade out towards the faces of their boxes, no detail of a shadow is smaller than their
    ///   cells and mean free paths, and texels are not halved below these. In tests with a cloud of
    ///   24³ samples, the share of light between texels is then off by up to 0.004 (root mean
    ///   square).
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
        while side > 16 && (bytes(all, side) > MAX_BYTES || bytes(most, side) > MAX_MAP_BYTES) {
            side /= 2;
        }
        let finest = self.finest(emitter);
        while side > 16 && f64::from(side / 2) >= finest {
            side /= 2;
        }
        side
    }

    /// Texels per side beyond which a map shows no more; infinite if there are edges.
    fn finest(&self, emitter: &Emitter) -> f64 {
        let has_triangles = match self.triangles {
            Triangles::None => false,
            Triangles::SeeThrough(geometry) => geometry.coatings().any_see_through(),
            Triangles::All(_) => true,
        };
        if has_triangles {
            return f64::INFINITY;
        }
        let Some(bounds) = self.bounds() else {
            return 0.0;
        };
        let mut finest = 0.0_f64;
        for caster in self.translucent {
            let Translucent::Grid(grid) = caster else {
                return f64::INFINITY;
            };
            let detail = detail(grid);
            for face in faces(bounds, emitter) {
                let width = match face.rays {
                    Rays::Parallel {
                        half_width,
                        half_height,
                    } => half_width.max(half_height),
                    Rays::Central { tan } => {
                        let corners = grid.occupied_bounds().corners();
                        let away = corners.map(|corner| corner.distance(face.origin));
                        tan * away.into_iter().fold(0.0, f32::max)
                    }
                };
                finest = finest.max(2.0 * f64::from(width) * detail);
            }
        }
        finest
    }
}

/// The most cells or mean free paths per metre of a grid; infinite if it has edges.
fn detail(grid: &DensityGrid) -> f64 {
    let of_density = f64::from(grid.scale()) * f64::from(grid.tint().max_element());
    let bounds = grid.bounds();
    let diagonal = f64::from(bounds.min().distance(bounds.max()));
    let edge = of_density * f64::from(grid.max_density_at_faces()) * diagonal;
    if grid.interpolation() == Interpolation::Constant || edge > FAINT {
        return f64::INFINITY;
    }
    let (_, cells_per_metre) = grid.cell_space();
    let cells = [0, 1, 2].map(|axis| cells_per_metre.row(axis).length());
    let sigma_t = of_density * f64::from(grid.max_density());
    cells.into_iter().fold(sigma_t, f64::max)
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};
    use gpu_backend::{Cpu, Host};
    use transmittance::baseline::{Captured, Uncompressed};

    use super::*;
    use crate::scene::{Bounds, Emission, Particle, Particles, Profile};
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
        let at = Vec3::new(0.5, 3.0, -1.0);
        let lamp = Emitter::point(at, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
        [sun.expect("a sun"), lamp.expect("a lamp")]
    }

    #[test]
    fn maps_of_smoke_without_edges_have_as_many_texels_as_it_has_details() {
        let cpu = Cpu::new();
        for scale in [0.5, 4.0, 40.0] {
            let smoke = [cloud(scale, 0.0, Interpolation::Linear).into()];
            let casters = Casters::new(&smoke, None);
            for emitter in &lights() {
                let few = casters.resolution(2048, &lights(), emitter);
                // A mean free path is 2 m over twice the scale.
                let expected = if scale <= 8.0 { 32..=128 } else { 64..=256 };
                assert!(expected.contains(&few), "{scale}: {few}");
                let build = |resolution| {
                    let clear = Captured::new();
                    let map: TransmittanceMap<Host, Uncompressed> =
                        TransmittanceMap::build(&cpu, &casters, emitter, resolution, &clear)
                            .expect("a map");
                    map
                };
                let (map, fine) = (build(few), build(512));
                let (mut sum, mut count) = (0.0, 0.0);
                for i in 0..40_u32.pow(3) {
                    let place = Vec3::new(
                        (i % 40) as f32 - 19.3,
                        (i / 40 % 40) as f32 - 19.6,
                        (i / 1600) as f32 - 19.8,
                    );
                    let place = place / 20.0;
                    let off = map.transmittance(place).x - fine.transmittance(place).x;
                    sum += f64::from(off * off);
                    count += 1.0;
                }
                let rmse = (sum / count).sqrt();
                println!("{scale}: {few} texels, {rmse:.1e}");
                assert!(rmse < 5e-3, "{scale}, {few} texels: {rmse}");
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
        let edges: [Translucent; 3] = [
            cloud(1.0, 0.0, Interpolation::Constant).into(),
            cloud(1.0, 0.1, Interpolation::Linear).into(),
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
        let nothing = Casters::new(&[], None);
        assert_eq!(nothing.resolution(1024, &lights(), &lights()[0]), 16);
    }
}
