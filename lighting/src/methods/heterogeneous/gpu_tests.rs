//! Media in shaders against the CPU, which defines the result.

use glam::{Affine3A, Quat, Vec3};
use gpu_backend::gpu::{Gpu, GpuMemory, InShader, Queued};
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Cpu, Download, assert_same_layout};
use reference::random::Random;
use reference::tolerances::Allowed;
use transmittance::{Linear, Packed, Stream};

use super::gpu::{
    EmissionScene, MAX_GRIDS, MediaError, MediaRecord, ROOMS, Scene, WALK, emission_shader, shader,
};
use super::tests::{HAZE, glowing, lights, rays, smoke};
use super::{
    AddEmission, EmittingRays, GatherMedia, MediaMemory, MediaOf, MediaRays, UploadedMedia,
};
use crate::gpu::PointSlot;
use crate::scene::gpu::MEDIA;
use crate::scene::trace::Tracer;
use crate::scene::{
    AlphaMode, Bounds, Cone, DensityGrid, Emission, Emitter, Geometry, HeightFog, Instance,
    Interpolation, Material, Media, Medium, Mesh, Particle, Particles, PhaseFunction, Profile,
    Scene as World, Texture, Translucent,
};
use crate::shadow_map::{self, RenderShadowMap, ShadowMap};
use crate::translucent::{Casters, TransmittanceMap};
use crate::visibility::{Both, PointVisibility};
use crate::{EyePanes, Ray};

/// The shader of a gather, which must be valid and keep to WebGPU's eight storage
/// buffers, of which the frame has six.
fn complete<V: InShader<PointSlot>>(room: &'static str) -> Shader {
    let assembly = shader::<V>([MEDIA, room, WALK]).unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = 6 + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

#[test]
fn gathers_compile_with_every_map_and_see_media_as_they_are() {
    type Map = ShadowMap<GpuMemory>;
    type Curves<T> = Both<Map, TransmittanceMap<GpuMemory, T>>;
    for (_, room) in ROOMS {
        complete::<Map>(room);
        complete::<Curves<Packed<16>>>(room);
    }
    let (size, room) = ROOMS[ROOMS.len() - 1];
    complete::<Curves<Packed<4, Linear>>>(room);
    let shader = complete::<Curves<Packed<8>>>(room);
    assert_eq!(
        shader.values("light_media_MAX_GRIDS").unwrap(),
        [size as f64]
    );
    assert_eq!(size, MAX_GRIDS);
    assert_same_layout!(
        shader,
        "light_Media",
        MediaRecord {
            even,
            height,
            low,
            grids,
            high,
            balls,
            first_ball,
            first_kind,
            first_phase,
            phases,
            first_box,
            boxes,
            even_phase,
            height_phase
        }
    );
    assert_same_layout!(
        shader,
        "Scene",
        Scene {
            emitter,
            medium,
            rays,
            steps,
            panes,
            is_gentle
        }
    );
}

#[test]
fn the_shader_of_emission_compiles_and_sees_its_scene_as_it_is() {
    for (_, room) in ROOMS {
        let shader = Shader::new(&emission_shader([MEDIA, room, WALK])).unwrap();
        assert_same_layout!(
            shader,
            "Scene",
            EmissionScene {
                rays,
                panes,
                padding_a,
                padding_b
            }
        );
    }
}

fn gathered<B, V>(
    backend: &B,
    (rays, panes): (&[Ray], Option<&EyePanes>),
    emitter: &Emitter,
    media: &MediaOf<'_, B::Memory>,
    visibility: &V,
) -> Vec<[f32; 4]>
where
    B: GatherMedia<V> + Download,
    B::Memory: MediaMemory,
{
    let there = backend.upload(rays).unwrap();
    let mut radiance = backend
        .upload(&vec![[0.0, 0.0, 0.0, 9.0]; rays.len()])
        .unwrap();
    let lit = MediaRays {
        rays: &there,
        emitter,
        media,
        steps: 32,
        panes,
        watch: &(),
    };
    backend
        .gather_media(&lit, visibility, &mut radiance)
        .unwrap();
    backend.download(&radiance).unwrap()
}

/// What is in the air of a test.
struct Air {
    name: &'static str,
    medium: Option<Medium>,
    height_fog: Option<HeightFog>,
    casters: Vec<Translucent>,
}

fn turned(grid: DensityGrid, angle: f32, shift: Vec3) -> DensityGrid {
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), angle);
    let transform = Affine3A::from_rotation_translation(turn, shift);
    grid.with_transform(transform).unwrap()
}

/// Smoke whose samples have colours, of another phase function.
fn coloured(scale: f32, interpolation: Interpolation) -> DensityGrid {
    let mut random = Random::new(5);
    let colours = (0..120).map(|_| 0.5 + 0.5 * Vec3::from(random.vector(1.0)));
    smoke(scale, interpolation)
        .with_albedo_samples(colours.collect())
        .unwrap()
        .with_tint(Vec3::new(1.0, 0.7, 0.4))
        .unwrap()
        .with_phase(PhaseFunction::Rayleigh)
        .unwrap()
}

/// Particles, of which more than 16 are at one place.
fn puffs(profile: Profile) -> Particles {
    let mut random = Random::new(11);
    let puff = |i: usize| Particle {
        centre: match i % 2 {
            0 => 0.3 * Vec3::from(random.vector(1.0)),
            _ => 1.2 * Vec3::from(random.vector(1.0)),
        },
        radius: 0.1 + 0.3 * random.unit(),
        sigma_t: 0.5 + 2.0 * random.unit(),
    };
    let particles = Particles::new((0..60).map(puff).collect(), profile).unwrap();
    particles.with_albedo(Vec3::new(0.9, 0.6, 0.8)).unwrap()
}

fn airs() -> Vec<Air> {
    let fog = Medium::new(Vec3::splat(0.05), Vec3::new(0.01, 0.0, 0.02), HAZE).unwrap();
    let bounds = Bounds::new(Vec3::splat(-1.5), Vec3::new(1.5, 0.4, 2.0)).unwrap();
    let mist = HeightFog::new(
        Vec3::splat(0.2),
        Vec3::ZERO,
        -0.5,
        0.4,
        PhaseFunction::Schlick { k: 0.5 },
    );
    let mist = mist.unwrap();
    let clear = |name, casters| Air {
        name,
        medium: None,
        height_fog: None,
        casters,
    };
    let linear = Interpolation::Linear;
    let overlapping = || -> Vec<Translucent> {
        vec![
            turned(smoke(2.0, linear), 0.4, Vec3::new(0.2, 0.1, 0.0)).into(),
            turned(coloured(1.0, Interpolation::Constant), 1.1, Vec3::ZERO).into(),
            coloured(0.5, linear).into(),
        ]
    };
    let one = |scale, interpolation| vec![smoke(scale, interpolation).into()];
    let five = (0..5)
        .map(|i| turned(smoke(0.5, linear), i as f32, Vec3::ZERO).into())
        .collect();
    vec![
        clear("one grid", one(1.0, linear)),
        clear("voxels", one(3.0, Interpolation::Constant)),
        clear("thin smoke", one(1e-12, linear)),
        clear("opaque smoke", one(1e6, linear)),
        clear("opaque voxels", one(1e12, Interpolation::Constant)),
        clear("turned grids", overlapping()),
        clear("five grids", five),
        clear("soft particles", vec![puffs(Profile::Soft).into()]),
        clear("particles", vec![puffs(Profile::Constant).into()]),
        Air {
            medium: Some(fog),
            ..clear("fog", Vec::new())
        },
        Air {
            height_fog: Some(mist),
            ..clear("mist", Vec::new())
        },
        Air {
            name: "all",
            medium: Some(fog.within(bounds)),
            height_fog: Some(mist),
            casters: [overlapping(), vec![puffs(Profile::Soft).into()]].concat(),
        },
    ]
}

fn more_lights() -> Vec<Emitter> {
    let mut all = lights();
    let texels = (0..35).map(|i| Vec3::new((i % 5) as f32, 1.0, (i % 3) as f32));
    let cookie = Texture::new(7, 5, texels.collect()).unwrap();
    let cone = Cone {
        inner: 0.2,
        outer: 0.7,
    };
    let aside = Quat::from_rotation_y(0.9) * Quat::from_rotation_x(-0.3);
    let slide = Emission::spot(aside, cone, Some(cookie)).unwrap();
    let point = |position, range, emission| {
        Emitter::point(position, Vec3::new(8.0, 9.0, 10.0), range, emission).unwrap()
    };
    all.push(point(Vec3::new(2.0, 0.6, 2.0), f32::INFINITY, slide));
    all.push(point(Vec3::new(-0.5, 0.5, 0.9), 2.0, Emission::Isotropic));
    all
}

fn many_rays() -> Vec<Ray> {
    let mut random = Random::new(3);
    let mut all = rays();
    for i in 0..300 {
        let origin = match i % 3 {
            0 => 0.7 * Vec3::from(random.vector(1.0)),
            _ => 4.0 * Vec3::from(random.vector(1.0)),
        };
        let towards = 0.8 * Vec3::from(random.vector(1.0)) - origin;
        let length = if i % 5 == 0 { f32::INFINITY } else { 6.0 };
        all.push(Ray::new(origin, towards, length).unwrap());
    }
    all
}

/// A few triangles in the smoke, `pane` of them see-through.
fn leaves(pane: bool) -> Geometry {
    let mut world = World::default();
    world.materials.push(Material {
        base_color: Vec3::new(0.9, 0.5, 0.3),
        transmission: if pane { 0.8 } else { 0.0 },
        alpha: AlphaMode::Opaque,
        ..Material::default()
    });
    let mut random = Random::new(21);
    for index in 0..8 {
        let corner = 0.8 * Vec3::from(random.vector(1.0));
        let mut next = || corner + 0.5 * Vec3::from(random.vector(1.0));
        world.meshes.push(Mesh {
            positions: vec![corner, next(), next()],
            triangles: vec![[0, 1, 2]],
            material: (index % 2 == 0).then_some(0),
            ..Mesh::default()
        });
        world.instances.push(Instance {
            mesh: index,
            ..Instance::default()
        });
    }
    Geometry::new(&world).unwrap()
}

/// Nothing is in the way.
struct Clear;

impl PointVisibility for Clear {
    type Share = f32;

    fn visibility(&self, _: Vec3) -> f32 {
        1.0
    }
}

/// The error that is allowed for a ray, of its unshadowed light.
fn allowed(ray: &Ray, light: &Emitter) -> f32 {
    let Emitter::Point(point) = light else {
        return Allowed::GpuMedia.error() as f32;
    };
    let to_light = (point.position() - ray.origin()).as_dvec3();
    let h = to_light.cross(ray.direction().as_dvec3()).length();
    let ratio = (to_light.length() / h).min(1e4);
    (Allowed::GpuMedia.error() + ratio * Allowed::GpuRadianceNearTheAxis.error()) as f32
}

/// How many rays there are, and how many of them differ by more than is allowed.
fn compare(gpu: &Gpu<Queued>, air: &Air, pane: bool) -> [usize; 2] {
    let cpu = Cpu::new();
    let media = Media::new(air.medium.as_ref(), air.height_fog.as_ref(), &air.casters);
    let there = UploadedMedia::new(gpu, &media).unwrap();
    let geometry = leaves(pane);
    let rays = many_rays();
    let panes = EyePanes::new(&cpu, &Tracer::new(&geometry), &rays);
    assert_eq!(panes.is_some(), pane);
    let solid = shadow_map::Casters::upload(&cpu, &geometry).unwrap();
    // Where light ends within the rounding of a point's place, that decides how much of it
    // gets there.
    let is_opaque = air.name.starts_with("opaque");
    let shadowing = if is_opaque { &[][..] } else { &air.casters };
    let casters = Casters::see_through(shadowing, &geometry);
    let seen = (&rays[..], panes.as_ref());
    let (mut all, mut different) = (0, 0);
    for (number, light) in more_lights().iter().enumerate() {
        let opaque = cpu.shadow_map(&solid, light, 64).unwrap();
        let clear = Stream::<8>::new();
        let curves: TransmittanceMap =
            TransmittanceMap::build(&cpu, &casters, light, 64, &clear).unwrap();
        let opaque_there = opaque.upload(gpu).unwrap();
        let curves_there = curves.upload(gpu).unwrap();
        let unshadowed = gathered(&cpu, seen, light, &media, &Clear);
        let expected = gathered(&cpu, seen, light, &media, &Both(&opaque, &curves));
        let both = Both(&opaque_there, &curves_there);
        let actual = gathered(gpu, seen, light, &there, &both);
        let mut worst = 0.0_f32;
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(actual[i][3], 9.0, "the fourth component is left alone");
            let allowed = allowed(ray, light);
            let agrees = (0..3).all(|c| {
                let (e, g) = (expected[i][c], actual[i][c]);
                assert!(g.is_finite() && g >= 0.0, "{} {ray:?}: {g}", air.name);
                let scale = unshadowed[i][c].max(1e-30);
                worst = worst.max((e - g).abs() / scale / allowed);
                (e - g).abs() <= scale * allowed
            });
            all += 1;
            different += usize::from(!agrees);
        }
        let sum = |all: &[[f32; 4]]| all.iter().map(|l| f64::from(l[1])).sum::<f64>();
        let (e, g) = (sum(&expected), sum(&actual));
        let name = air.name;
        println!("{name} {number}: {worst:.1e} of the allowed error, {e:.6e} and {g:.6e}");
        let allowed = Allowed::GpuMedia.error() + Allowed::GpuMediaRays.error();
        assert!((g - e).abs() <= allowed * e, "{name} {number}");
    }
    [all, different]
}

#[test]
fn gathers_through_the_same_media_agree() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut all, mut different) = (0, 0);
    for (number, air) in airs().iter().enumerate() {
        let [count, differ] = compare(&gpu, air, number % 2 == 1);
        println!("{}: {differ} of {count} rays differ", air.name);
        all += count;
        different += differ;
    }
    println!("{different} of {all} rays differ");
    let share = different as f64 / all as f64;
    assert!(share <= Allowed::GpuMediaRays.error(), "{share}");
}

fn emitted<B>(
    backend: &B,
    rays: &[Ray],
    panes: Option<&EyePanes>,
    media: &MediaOf<'_, B::Memory>,
) -> Vec<[f32; 4]>
where
    B: AddEmission + Download,
    B::Memory: MediaMemory,
{
    let mut radiance = backend
        .upload(&vec![[0.0, 0.0, 0.0, 9.0]; rays.len()])
        .unwrap();
    let rays = &backend.upload(rays).unwrap();
    let seen = EmittingRays { rays, media, panes };
    backend.add_emission(&seen, &mut radiance).unwrap();
    backend.download(&radiance).unwrap()
}

#[test]
fn what_the_same_media_emit_agrees() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let rays = many_rays();
    let panes = EyePanes::new(&cpu, &Tracer::new(&leaves(true)), &rays);
    let (mut all, mut different) = (0_usize, 0_usize);
    // A ray may enter one grid before another by as much as its place is off, up to
    // 2⁻²² of 8 m, and two grids glow with up to 2 per metre.
    let moved = 4.0 * 8.0 * 2.0_f32.powi(-22);
    for air in airs() {
        for interpolation in [Interpolation::Constant, Interpolation::Linear] {
            for scale in [0.0, 1.0, 1e6] {
                let mut casters = air.casters.clone();
                let tint = Vec3::new(1.0, 0.2, 0.6);
                casters.push(
                    glowing(scale, interpolation)
                        .with_tint(tint)
                        .unwrap()
                        .into(),
                );
                casters.push(turned(glowing(0.3, interpolation), 0.7, Vec3::X).into());
                let media = Media::new(air.medium.as_ref(), air.height_fog.as_ref(), &casters);
                let there = UploadedMedia::new(&gpu, &media).unwrap();
                let expected = emitted(&cpu, &rays, panes.as_ref(), &media);
                let actual = emitted(&gpu, &rays, panes.as_ref(), &there);
                let (mut worst, before) = (0.0_f32, different);
                for (expected, actual) in expected.iter().zip(&actual) {
                    assert_eq!(actual[3], 9.0, "the fourth component is left alone");
                    let agrees = (0..3).all(|c| {
                        let (e, g) = (expected[c], actual[c]);
                        let allowed = Allowed::GpuMedia.error() as f32 * e + moved;
                        let ratio = (e - g).abs() / allowed;
                        worst = worst.max(ratio);
                        ratio <= 1.0
                    });
                    all += 1;
                    different += usize::from(!agrees);
                }
                let differ = different - before;
                let name = air.name;
                println!("{name} {interpolation:?} {scale}: {worst:.1e}, {differ} rays differ");
            }
        }
    }
    println!("{different} of {all} rays differ");
    let share = different as f64 / all as f64;
    assert!(share <= Allowed::GpuMediaRays.error(), "{share}");
}

#[test]
fn more_than_a_ray_has_room_for_is_refused() {
    let Some(gpu) = testing::gpu() else { return };
    let grids: Vec<Translucent> = (0..=MAX_GRIDS)
        .map(|_| smoke(1.0, Interpolation::Linear).into())
        .collect();
    let media = Media::new(None, None, &grids[1..]);
    assert!(UploadedMedia::new(&gpu, &media).is_ok());
    let media = Media::new(None, None, &grids);
    let error = UploadedMedia::new(&gpu, &media).unwrap_err();
    let (what, count) = ("grids", MAX_GRIDS + 1);
    assert_eq!(error, MediaError::TooMany { what, count });
    assert!(error.to_string().contains("17 grids"), "{error}");
}

#[test]
fn nothing_in_the_air_is_nothing_to_see() {
    let Some(gpu) = testing::gpu() else { return };
    let media = Media::new(None, None, &[]);
    let there = UploadedMedia::new(&gpu, &media).unwrap();
    let solid = shadow_map::Casters::upload(&gpu, &leaves(false)).unwrap();
    for light in &lights() {
        let map = gpu.shadow_map(&solid, light, 16).unwrap();
        for found in gathered(&gpu, (&rays(), None), light, &there, &map) {
            assert_eq!(found, [0.0, 0.0, 0.0, 9.0]);
        }
    }
}
