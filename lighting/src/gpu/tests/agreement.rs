//! The gather on a GPU against the CPU, which defines the result.

use crate::airlight::{Midpoint, Quadrature};
use crate::emitter::Emission;
use crate::scene::{Bounds, Cone, Geometry, Instance, Medium, Mesh, PhaseFunction, Scene, Texture};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMapError};
use crate::visibility::{MergeTouching, ShadowMapMarch, Spacing, Unshadowed};
use crate::{AirlightEvaluator, Emitter, Gather, Ray, VisibilitySource};
use glam::{Affine3A, Quat, Vec3};
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Buffer, Cpu, Download, Error, Memory, testing};

/// Numbers in [0, 1) that are the same on every run.
struct Sequence(u32);

impl Sequence {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / 4_294_967_296.0
    }

    fn vector(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.next(), self.next(), self.next()) - 1.0
    }
}

const LIGHT: Vec3 = Vec3::new(1.0, 2.0, -4.0);

fn lights() -> Vec<(&'static str, Emitter)> {
    let point = |range, emission| {
        Emitter::point(LIGHT, Vec3::new(50.0, 30.0, 5.0), range, emission).unwrap()
    };
    let spot = |inner, outer, slide| {
        let rotation = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-0.7);
        Emission::spot(rotation, Cone { inner, outer }, slide).unwrap()
    };
    let texels = (0..35)
        .map(|i| Vec3::new(i as f32, 1.0, (i % 3) as f32))
        .collect();
    let slide = Texture::new(7, 5, texels).unwrap();
    vec![
        ("point", point(f32::INFINITY, Emission::Isotropic)),
        ("range", point(3.0, Emission::Isotropic)),
        (
            "cosine",
            point(
                f32::INFINITY,
                Emission::Cosine {
                    normal: Vec3::new(0.6, -0.8, 0.0),
                },
            ),
        ),
        ("spot", point(f32::INFINITY, spot(0.2, 0.6, None))),
        (
            "half space",
            point(9.0, spot(0.0, std::f32::consts::FRAC_PI_2, None)),
        ),
        ("slide", point(f32::INFINITY, spot(0.1, 0.8, Some(slide)))),
        (
            "sun",
            Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::splat(4.0)).unwrap(),
        ),
        (
            "sun along an axis",
            Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap(),
        ),
    ]
}

fn media() -> Vec<(&'static str, Medium)> {
    let medium = |s: Vec3, a: Vec3, phase| Medium::new(s, a, phase).unwrap();
    let thin = medium(
        Vec3::splat(0.02),
        Vec3::new(0.0, 0.01, 0.02),
        PhaseFunction::Isotropic,
    );
    let forward = PhaseFunction::HenyeyGreenstein { g: 0.8 };
    let bounds = Bounds::new(Vec3::new(-3.0, -1.0, -8.0), Vec3::new(4.0, 3.0, 1.0)).unwrap();
    vec![
        ("thin", thin),
        (
            "dense",
            medium(
                Vec3::new(1.0, 0.5, 2.0),
                Vec3::ZERO,
                PhaseFunction::Rayleigh,
            ),
        ),
        (
            "forward",
            medium(Vec3::splat(0.1), Vec3::splat(0.1), forward),
        ),
        (
            "backward",
            medium(
                Vec3::splat(0.1),
                Vec3::ZERO,
                PhaseFunction::HenyeyGreenstein { g: -0.5 },
            ),
        ),
        (
            "box",
            medium(Vec3::splat(0.3), Vec3::splat(0.1), forward).within(bounds),
        ),
    ]
}

/// A third passes the light at `closest` to 1 of its distance.
fn rays(count: usize, closest: f32) -> Vec<Ray> {
    let mut sequence = Sequence(7);
    (0..count)
        .map(|i| {
            let origin = 5.0 * sequence.vector();
            let direction = match i % 3 {
                0 => {
                    let to_light = LIGHT - origin;
                    let aside = to_light.cross(sequence.vector()).normalize_or(Vec3::X);
                    to_light + to_light.length() * closest.powf(sequence.next()) * aside
                }
                _ => sequence.vector(),
            };
            let length = match i % 5 {
                0 => f32::INFINITY,
                1 => 0.0,
                _ => 30.0 * sequence.next(),
            };
            Ray::new(origin, direction, length).unwrap()
        })
        .collect()
}

fn gathered<B, V, A>(
    backend: &B,
    rays: &[Ray],
    light: &Emitter,
    medium: &Medium,
    (visibility, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let before = vec![[0.0, 0.0, 0.0, 9.0]; rays.len()];
    let rays = backend.upload(rays).unwrap();
    let mut radiance = backend.upload(&before).unwrap();
    backend
        .gather(&rays, light, medium, visibility, airlight, &mut radiance)
        .unwrap();
    backend.download(&radiance).unwrap()
}

/// What a light that shines everywhere would give, which is what errors at the
/// border of a cone are measured by.
fn without_borders(light: &Emitter) -> Emitter {
    match light {
        Emitter::Point(point) => Emitter::point(
            point.position(),
            point.intensity(),
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap(),
        sun => sun.clone(),
    }
}

/// The relative error that is allowed for a ray.
///
/// With ε = 2^-24. Terms that do not depend on the ray: rounding in the
/// evaluation, 3 + 2τ ULP of the exponential (τ ≤ 10 where the value matters),
/// and the error 2ε of cos θ, which the peak of a Henyey–Greenstein function
/// multiplies by 3g/(1−g)², 60 at g = 0.8: 256 ε in all. The distance h between
/// ray and light is a cross product of vectors of the length D with an error of
/// about 4 ε D on the GPU, where the CPU has f64; the radiance is inversely
/// proportional to it and the phase function and emission turn with it, up to
/// a few times as fast: 16 ε D/h.
fn allowed(ray: &Ray, light: &Emitter) -> f32 {
    let epsilon = 0.5_f32.powi(24);
    let Emitter::Point(point) = light else {
        return 256.0 * epsilon;
    };
    let to_light = (point.position() - ray.origin()).as_dvec3();
    let h = to_light.cross(ray.direction().as_dvec3()).length();
    let ratio = (to_light.length() / h).min(1e4) as f32;
    epsilon * (256.0 + 16.0 * ratio)
}

fn compare<V, A>(gpu: &Gpu<Queued>, name: &str, pair: (&V, &A), closest: f32)
where
    V: VisibilitySource,
    A: AirlightEvaluator,
    Gpu<Queued>: Gather<V, A>,
{
    let cpu = Cpu::new();
    let rays = rays(3000, closest);
    let reference = Quadrature::new(8).unwrap();
    let mut worst = 0.0_f32;
    for (light_name, light) in lights() {
        for (medium_name, medium) in media() {
            let expected = gathered(&cpu, &rays, &light, &medium, pair);
            let actual = gathered(gpu, &rays, &light, &medium, pair);
            let everywhere = without_borders(&light);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, (&Unshadowed, &reference));
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(actual[i][3], 9.0, "the fourth component is left alone");
                for c in 0..3 {
                    let (e, g) = (expected[i][c], actual[i][c]);
                    let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                    let ratio = (e - g).abs() / scale / allowed(ray, &light);
                    worst = worst.max(ratio);
                    assert!(
                        ratio <= 1.0,
                        "{name} {light_name} {medium_name}: {e} on the CPU, {g} on the GPU, \
                         {ratio} of the allowed error for {ray:?}"
                    );
                }
            }
        }
    }
    println!("{name}: {worst} of the allowed error");
}

#[test]
fn the_gpu_agrees_with_the_cpu_for_all_lights_media_and_pairs() {
    let Some(gpu) = testing::gpu() else { return };
    let quadrature = Quadrature::new(8).unwrap();
    compare(&gpu, "quadrature", (&Unshadowed, &quadrature), 1e-4);
    compare(&gpu, "midpoint", (&Unshadowed, &Midpoint), 1e-4);
    compare(
        &gpu,
        "merged",
        (&MergeTouching(Unshadowed), &quadrature),
        1e-4,
    );
}

/// Two hundred triangles in the space around the light.
fn casters() -> Geometry {
    let mut sequence = Sequence(99);
    let positions: Vec<Vec3> = (0..200)
        .flat_map(|_| {
            let corner = 6.0 * sequence.vector();
            [
                corner,
                corner + sequence.vector(),
                corner + sequence.vector(),
            ]
        })
        .collect();
    let mesh = Mesh {
        triangles: (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        positions,
        ..Mesh::default()
    };
    let scene = Scene {
        meshes: vec![mesh],
        instances: vec![Instance {
            mesh: 0,
            transform: Affine3A::IDENTITY,
        }],
        ..Scene::default()
    };
    Geometry::new(&scene).unwrap()
}

/// Share of the rays that may differ because a sample within rounding of the
/// border of a texel fell to its other side.
///
/// A texel coordinate of a map of 256 is off by about 4 ε × 256 = 6e-5, so the
/// chance that a sample lies that close to one of four borders is 2.4e-4. A
/// ray has 16 samples, and at most every tenth is next to a texel of a different
/// answer.
const OTHER_TEXEL: f32 = 4e-4;

#[test]
fn marches_through_the_same_map_agree_but_for_samples_on_the_border_of_a_texel() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let quadrature = Quadrature::new(2).unwrap();
    let rays = rays(4000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let map = cpu.shadow_map(&casters, &light, 256).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        for spacing in [Spacing::Distance, Spacing::EquiAngular] {
            for (_, medium) in media() {
                let here = ShadowMapMarch::new(&map, 16, spacing);
                let there = ShadowMapMarch::new(&map_there, 16, spacing);
                let scale = {
                    let everywhere = without_borders(&light);
                    let pair = (&Unshadowed, &quadrature);
                    gathered(&cpu, &rays, &everywhere, &medium, pair)
                };
                let mut count = |expected: Vec<[f32; 4]>, actual: Vec<[f32; 4]>| {
                    for (i, ray) in rays.iter().enumerate() {
                        let agrees = (0..3).all(|c| {
                            let (e, g) = (expected[i][c], actual[i][c]);
                            let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                            (e - g).abs() <= scale * allowed(ray, &light)
                        });
                        all += 1;
                        different += u32::from(!agrees);
                    }
                };
                count(
                    gathered(&cpu, &rays, &light, &medium, (&here, &Midpoint)),
                    gathered(&gpu, &rays, &light, &medium, (&there, &Midpoint)),
                );
                let (here, there) = (MergeTouching(here), MergeTouching(there));
                count(
                    gathered(&cpu, &rays, &light, &medium, (&here, &quadrature)),
                    gathered(&gpu, &rays, &light, &medium, (&there, &quadrature)),
                );
            }
        }
    }
    let share = different as f32 / all as f32;
    println!("{different} of {all} rays differ");
    assert!(share <= OTHER_TEXEL, "{different} of {all} rays differ");
}

#[test]
fn empty_bundles_and_wrong_lengths_are_handled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let (_, light) = lights().swap_remove(0);
    let (_, medium) = media().swap_remove(0);
    let pair = (&Unshadowed, &Midpoint);
    assert!(gathered(&gpu, &[], &light, &medium, pair).is_empty());
    let buffer = gpu.upload(&rays(3, 1.0)).unwrap();
    let mut short = gpu.zeros::<[f32; 4]>(2).unwrap();
    let error = gpu
        .gather(&buffer, &light, &medium, pair.0, pair.1, &mut short)
        .unwrap_err();
    assert!(matches!(
        error,
        Error::LengthMismatch {
            expected: 3,
            actual: 2,
            ..
        }
    ));
}

/// Relative error of a depth: the corners are off by 2 ε of their distance of up
/// to ten times the depth, seen at angles down to 3° here, 20 times as flat as
/// face on: 400 ε.
const DEPTH_ERROR: f32 = 400.0 / 16_777_216.0;

/// How many texels of a map may hold another triangle than on the CPU, out of
/// its pairs of neighbours of different depth: rasterisers snap corners to a
/// 1/16 of a texel or finer, which moves an edge by half of that.
fn on_an_edge(depth: &[f32], resolution: u32) -> usize {
    let side = resolution as usize;
    let differ = |a: f32, b: f32| (a - b).abs() > 0.01 * a;
    let edges = (0..depth.len())
        .map(|i| {
            let right = i % side + 1 < side && differ(depth[i], depth[i + 1]);
            let below = i / side % side + 1 < side && differ(depth[i], depth[i + side]);
            usize::from(right) + usize::from(below)
        })
        .sum::<usize>();
    // Triangles smaller than a texel have edges that no pair shows.
    1 + edges / 32
}

#[test]
fn shadow_maps_of_both_backends_agree_but_for_texels_on_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let geometry = casters();
    let here = Casters::upload(&cpu, &geometry).unwrap();
    let there = Casters::upload(&gpu, &geometry).unwrap();
    for (name, light) in lights() {
        let mut resolutions = vec![1, 7, 64, 200];
        if let Emitter::Directional(_) = light {
            // Four tiles.
            resolutions.push(2050);
        }
        for resolution in resolutions {
            let expected = cpu.shadow_map(&here, &light, resolution).unwrap();
            let actual = gpu.shadow_map(&there, &light, resolution).unwrap();
            assert_eq!(actual.faces(), expected.faces());
            assert_eq!(actual.resolution(), resolution);
            let expected = expected.depth();
            let actual = gpu.download(actual.depth()).unwrap();
            let others = (expected.iter().zip(&actual))
                .filter(|(e, g)| !((*e - *g).abs() <= DEPTH_ERROR * **e))
                .count();
            let allowed = on_an_edge(expected, resolution);
            assert!(
                others <= allowed,
                "{name} {resolution}: {others} texels differ, expected at most {allowed}"
            );
        }
    }
}

#[test]
fn senseless_maps_are_refused_on_the_gpu_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let casters = Casters::upload(&gpu, &casters()).unwrap();
    let (_, point) = lights().swap_remove(0);
    for resolution in [0, 65537, u32::MAX] {
        assert_eq!(
            gpu.shadow_map(&casters, &point, resolution).unwrap_err(),
            ShadowMapError::Resolution { resolution }
        );
    }
    let error = gpu.shadow_map(&casters, &point, 65536).unwrap_err();
    assert!(error.to_string().contains("limit"), "{error}");
}

/// Casters to picture, for any backend.
fn picture<B, M>(
    backend: &B,
    rays: &M::Buffer<Ray>,
    light: &Emitter,
    medium: &Medium,
) -> M::Buffer<[f32; 4]>
where
    M: Memory,
    B: RenderShadowMap<Memory = M> + for<'a> Gather<ShadowMapMarch<'a, M>, Quadrature>,
{
    let casters = Casters::upload(backend, &casters()).unwrap();
    let map = backend.shadow_map(&casters, light, 128).unwrap();
    let mut radiance = backend.zeros(rays.len()).unwrap();
    let march = ShadowMapMarch::new(&map, 8, Spacing::EquiAngular);
    let quadrature = Quadrature::new(2).unwrap();
    backend
        .gather(rays, light, medium, &march, &quadrature, &mut radiance)
        .unwrap();
    radiance
}

#[test]
fn a_whole_picture_is_one_read_back_and_the_same_when_the_caller_records_it() {
    let Some(gpu) = testing::gpu() else { return };
    let rays = gpu.upload(&rays(300, 0.1)).unwrap();
    let (_, light) = lights().swap_remove(0);
    let (_, medium) = media().swap_remove(0);
    let queued = picture(&gpu, &rays, &light, &medium);
    assert_eq!(gpu.statistics().submits, 0);
    let queued = gpu.download(&queued).unwrap();
    assert_eq!(
        (gpu.statistics().submits, gpu.statistics().read_backs),
        (1, 1)
    );
    assert!(queued.iter().any(|radiance| radiance[0] > 0.0));

    let context = gpu.context();
    let mut encoder = context
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recorded = picture(&Gpu::record(context, &mut encoder), &rays, &light, &medium);
    context.queue().submit([encoder.finish()]);
    assert_eq!(gpu.download(&recorded).unwrap(), queued);
}
