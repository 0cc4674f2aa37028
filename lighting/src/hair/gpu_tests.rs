//! Light of hair in shaders against the CPU, which defines the result.

use std::fmt::Debug;

use glam::{Quat, Vec3};
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
use reference::random::Random;
use reference::tolerances::Allowed;
use transmittance::gpu::WgslStored;
use transmittance::{Accumulate, Curve, Evaluate, Linear, Packed, Stored, Stream};

use super::gpu::{ADD, FIBRE, Pixels, STORAGE, Scene as SceneRecord, batches, shader};
use super::light::HairPoint;
use super::tests::{FIBRES, SIDE, Seen, added, strands, sun, tangle};
use super::{AddHairLight, Fibre, LitHair};
use crate::gpu::NUMERIC;
use crate::methods::exact::UploadedTracer;
use crate::methods::translucent::{Casters, TransmittanceMap};
use crate::scene::{
    Cone, Emission, Emitter, HeightFog, Instance, Media, Medium, Mesh, Particle, Particles,
    PhaseFunction, Profile, Scene, Texture,
};

/// The shader for a kind of curves, which must be valid and keep to WebGPU's eight storage
/// buffers.
fn complete<T: WgslStored + Debug>() -> Shader {
    let assembly = shader::<T>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = STORAGE + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

#[test]
fn shaders_compile_for_every_kind_of_curves_and_see_their_scene_as_it_is() {
    complete::<Packed<16>>();
    complete::<Packed<4, Linear>>();
    let shader = complete::<Packed<8>>();
    assert_same_layout!(
        shader,
        "Scene",
        SceneRecord {
            emitter,
            medium,
            height,
            points,
            fibre,
            has_height,
            texels
        }
    );
    assert_same_layout!(
        shader,
        "light_HairPoint",
        HairPoint {
            position,
            radius,
            tangent,
            padding_a,
            to_eye,
            padding_b,
            colour,
            padding_c,
            response,
            padding_d
        }
    );
    for (fibre, name) in [
        (Fibre::KajiyaKay, "light_KAJIYA_KAY"),
        (Fibre::Marschner, "light_MARSCHNER"),
    ] {
        let number = f64::from(fibre.number());
        assert_eq!(shader.values(name).unwrap(), [number]);
    }
    let adds = Shader::new(&ADD).unwrap();
    assert_same_layout!(
        adds,
        "Pixels",
        Pixels {
            count,
            first,
            begin,
            most
        }
    );
    let part = Shader::new(&[NUMERIC, FIBRE]).unwrap();
    part.require_part(&["light_"]).unwrap();
}

#[test]
fn batches_hold_all_pixels_in_order_and_no_more_than_asked_for() {
    let seen = Seen::new(super::tests::with(strands(&tangle(1, 60), 0.03, 0.6)), SIDE);
    for most in [1, 7, 50, usize::MAX] {
        let mut next = 0;
        for pixels in batches(&seen.hair, most) {
            assert_eq!(pixels.start, next);
            next = pixels.end;
            let held: usize = pixels.clone().map(|pixel| seen.hair.of(pixel).len()).sum();
            assert!(held <= most || pixels.len() == 1, "{held} of {most}");
        }
        assert_eq!(next, seen.hair.pixels());
    }
}

/// The light of hair on both backends by a map with these curves.
fn on_both<A, T>(
    gpu: &Gpu<Queued>,
    seen: &Seen,
    emitters: &[Emitter],
    fibre: Fibre,
    clear: &A,
) -> [Vec<[f32; 4]>; 2]
where
    A: Accumulate + Clone + Sync,
    A::Curve: Into<T>,
    T: Evaluate + Stored + WgslStored + Debug + Send + Sync,
{
    let cpu = Cpu::new();
    let casters = Casters::new(&seen.scene.translucent, None);
    let map = |emitter| TransmittanceMap::build(&cpu, &casters, emitter, 128, clear).unwrap();
    let maps: Vec<_> = emitters.iter().map(map).collect();
    let there: Vec<_> = maps.iter().map(|map| map.upload(gpu).unwrap()).collect();
    let media = Media::of(&seen.scene);
    let (view, translucent) = (&seen.view, &seen.scene.translucent[..]);
    let lights: Vec<_> = emitters.iter().zip(&maps).collect();
    let of_cpu = added(
        &cpu,
        &seen.hair,
        &LitHair {
            view,
            translucent,
            media: &media,
            tracer: &seen.tracer,
            lights: &lights,
            fibre,
        },
    );
    let lights: Vec<_> = emitters.iter().zip(&there).collect();
    let of_gpu = added(
        gpu,
        &seen.hair,
        &LitHair {
            view,
            translucent,
            media: &media,
            tracer: &UploadedTracer::new(gpu, &seen.tracer).unwrap(),
            lights: &lights,
            fibre,
        },
    );
    [of_cpu, of_gpu]
}

/// Strands among walls, in fog, smoke and fog that thins out with altitude.
fn scenes() -> Vec<Scene> {
    let hair = || super::tests::with(strands(&tangle(3, 300), 0.02, 0.5));
    let mut random = Random::new(4);
    let mut walls = hair();
    let corners = (0..60).flat_map(|_| {
        let centre = Vec3::from_array(random.vector(2.0)) + 2.0 * Vec3::NEG_Z;
        [0; 3].map(|_| centre + Vec3::from_array(random.vector(0.4)))
    });
    let positions: Vec<Vec3> = corners.collect();
    walls.meshes.push(Mesh {
        triangles: (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        positions,
        ..Mesh::default()
    });
    walls.instances.push(Instance {
        mesh: 1,
        ..Instance::default()
    });
    let fog = |phase| Medium::new(Vec3::splat(0.05), Vec3::new(0.1, 0.2, 0.3), phase).unwrap();
    let mut foggy = hair();
    foggy.medium = Some(fog(PhaseFunction::Isotropic));
    let puff = |x: f32| Particle {
        centre: Vec3::new(x, 0.4, -2.0),
        radius: 0.6,
        sigma_t: 1.5,
    };
    foggy.translucent.push(
        Particles::new(vec![puff(-0.5), puff(0.6)], Profile::Soft)
            .unwrap()
            .into(),
    );
    let mut high = hair();
    let phase = PhaseFunction::Isotropic;
    let coefficients = [Vec3::splat(0.1), Vec3::new(0.2, 0.1, 0.3)];
    let [sigma_s, sigma_a] = coefficients;
    high.height_fog = Some(HeightFog::new(sigma_s, sigma_a, 0.0, 1.5, phase).unwrap());
    vec![hair(), walls, foggy, high]
}

fn lamps() -> Vec<Emitter> {
    let lamp = |position, emission| {
        Emitter::point(position, Vec3::new(8.0, 6.0, 4.0), 9.0, emission).unwrap()
    };
    let texels = (0..12)
        .map(|i| Vec3::new(0.3, 0.1 * i as f32, 1.0))
        .collect();
    let texture = Texture::new(4, 3, texels).unwrap();
    let cone = Cone {
        inner: 0.5,
        outer: 0.8,
    };
    let spot = Emission::spot(Quat::from_rotation_x(-0.6), cone, Some(texture)).unwrap();
    vec![
        sun(),
        lamp(Vec3::new(1.5, 2.0, 0.5), Emission::Isotropic),
        lamp(Vec3::new(0.0, 0.2, -2.0), Emission::Isotropic),
        lamp(Vec3::new(0.0, 1.5, 0.5), spot),
    ]
}

/// Pixels that differ by more than rounding, of those that are lit.
fn differ(found: &[[f32; 4]], expected: &[[f32; 4]]) -> [usize; 2] {
    let error = Allowed::GpuHair.error() as f32;
    let lit = expected.iter().filter(|pixel| pixel[..3] != [0.0; 3]);
    let differs = |(found, expected): &(&[f32; 4], &[f32; 4])| {
        let scale = expected[..3].iter().fold(0.0, |a: f32, b| a.max(*b));
        (0..3).any(|c| (found[c] - expected[c]).abs() > error * scale)
    };
    [
        found.iter().zip(expected).filter(differs).count(),
        lit.count(),
    ]
}

#[test]
fn hair_of_both_backends_is_lit_alike() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut differing, mut lit) = (0, 0);
    let mut worst: f32 = 0.0;
    for scene in scenes() {
        let seen = Seen::new(scene, SIDE);
        for lamp in lamps() {
            for fibre in FIBRES {
                let lamps = [lamp.clone()];
                let [expected, found] =
                    on_both::<_, Packed<8>>(&gpu, &seen, &lamps, fibre, &Stream::<8>::new());
                let [off, of] = differ(&found, &expected);
                for (a, b) in found.iter().zip(&expected) {
                    worst = worst.max((a[0] - b[0]).abs() / b[0].max(1e-20));
                }
                (differing, lit) = (differing + off, lit + of);
            }
        }
    }
    println!("{differing} of {lit} pixels, worst {worst:e}");
    assert!(lit > 5000, "{lit}");
    let allowed = Allowed::GpuHairPixels.error() * lit as f64;
    assert!(differing as f64 <= allowed, "{differing} of {lit}");
}

#[test]
fn lights_add_up_whatever_the_curves() {
    let Some(gpu) = testing::gpu() else { return };
    let seen = Seen::new(scenes().remove(1), SIDE);
    let [expected, found] = on_both::<_, Packed<4, Linear>>(
        &gpu,
        &seen,
        &lamps(),
        Fibre::Marschner,
        &Curve::<4, Linear>::new(),
    );
    let [off, of] = differ(&found, &expected);
    let allowed = Allowed::GpuHairPixels.error() * of as f64;
    assert!(off as f64 <= allowed, "{off} of {of}");
}

#[test]
fn what_was_there_is_kept_and_other_lengths_are_refused() {
    let Some(gpu) = testing::gpu() else { return };
    let seen = Seen::new(scenes().remove(0), SIDE);
    let tracer = UploadedTracer::new(&gpu, &seen.tracer).unwrap();
    let media = Media::of(&seen.scene);
    let lit: LitHair<'_, GpuMemory> = LitHair {
        view: &seen.view,
        translucent: &seen.scene.translucent,
        media: &media,
        tracer: &tracer,
        lights: &[],
        fibre: Fibre::Marschner,
    };
    let before = vec![[1.0, 2.0, 3.0, 4.0]; seen.view.rays().len()];
    let mut radiance = gpu.upload(&before).unwrap();
    gpu.add_hair_light(&seen.hair, &lit, &mut radiance).unwrap();
    assert_eq!(gpu.download(&radiance).unwrap(), before);
    let mut short = gpu.upload(&before[1..]).unwrap();
    assert!(gpu.add_hair_light(&seen.hair, &lit, &mut short).is_err());
}
