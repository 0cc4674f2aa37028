//! Many lights on surfaces in shaders: without a device, and against the CPU with one.

use glam::Vec3;
use gpu_backend::gpu::{GpuMemory, InShader};
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Cpu, Download, assert_same_layout};
use reference::random::Random;
use reference::tolerances::Allowed;

use super::gpu::{STORAGE, Scene, shader};
use super::tests::{before, bits, fog, points};
use super::*;
use crate::Ray;
use crate::culling::tests::{WIDTH, lights, rays};

/// The shader of a source, which must be valid and keep to WebGPU's eight storage buffers.
fn complete<V: InShader<ManySurfacesSlot>>() -> Shader {
    let assembly = shader::<V>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = STORAGE + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

#[test]
fn shaders_of_every_source_compile_and_see_their_scene_as_it_is() {
    let shader = complete::<Unshadowed>();
    assert_same_layout!(
        shader,
        "Scene",
        Scene {
            medium,
            points,
            lists,
            entry,
            most,
            cookies,
            padding_a,
            padding_b,
            padding_c
        }
    );
    #[cfg(feature = "shadow-map")]
    {
        use crate::gpu::many_maps::MapRecord;
        use crate::shadow_map::FilteredMapsOfMany;

        let maps = complete::<FilteredMapsOfMany<'_, GpuMemory>>();
        assert_same_layout!(
            maps,
            "light_MapOfMany",
            MapRecord {
                pictures,
                first,
                bias,
                padding_a,
                padding_b
            }
        );
    }
    #[cfg(feature = "shadow-dag")]
    {
        use crate::precomputed::FilteredShadows;
        use crate::shadow_map::FilteredMapsOfMany;
        use crate::visibility::Both;

        complete::<FilteredShadows<'_, GpuMemory>>();
        complete::<Both<FilteredShadows<'_, GpuMemory>, FilteredMapsOfMany<'_, GpuMemory>>>();
    }
}

/// Lit points on a backend, by all lights, those of lists, and some lights at a time, have
/// the same bits.
fn check_lists<V, B>(
    backend: &B,
    (rays, points): (&[Ray], &[SurfacePoint]),
    emitters: &[Emitter],
    medium: Option<&Medium>,
    shadows: &V,
) -> Vec<[f32; 4]>
where
    B: AddDirectLight<V> + Download,
{
    let uploaded = backend.upload(points).unwrap();
    let culled = PointLists::of_picture(&Cpu::new(), rays, WIDTH, emitters);
    let all = PointLists::all(points.len(), emitters.len());
    let lit = |lists: &PointLists, lights_per_dispatch| {
        let mut found = backend.upload(&before(points.len())).unwrap();
        let lit = LitPoints {
            lights_per_dispatch,
            ..LitPoints::new(&uploaded, emitters, lists, medium)
        };
        backend.add_direct_light(&lit, shadows, &mut found).unwrap();
        backend.download(&found).unwrap()
    };
    let expected = lit(&all, usize::MAX);
    for found in [lit(&culled, usize::MAX), lit(&culled, 2), lit(&all, 5)] {
        assert!(bits(&found) == bits(&expected));
    }
    expected
}

/// Points that differ by more than rounding, relative to the light of all lights.
fn differ(found: &[[f32; 4]], expected: &[[f32; 4]], scale: &[[f32; 4]]) -> usize {
    let error = Allowed::GpuDirectLight.error() as f32;
    let differs = |i: &usize| {
        let near = |channel: usize| {
            let [a, b, scale] = [found, expected, scale].map(|sums| sums[*i][channel]);
            (a - b).abs() <= error * (1.0 + scale.abs())
        };
        !(0..4).all(near)
    };
    (0..found.len()).filter(differs).count()
}

#[test]
fn points_of_both_backends_are_lit_alike_whatever_the_lists() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(1);
    let cpu = Cpu::new();
    let (mut points_lit, mut differing) = (0, 0);
    for set in 0..12 {
        let rays = rays(&mut random);
        let mut emitters = lights(&mut random, &rays, 9 + set);
        emitters.insert(4, Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap());
        let points = points(&mut random, &rays);
        let medium = fog();
        for medium in [None, Some(&medium)] {
            let of = (&rays[..], &points[..]);
            let found = check_lists(&gpu, of, &emitters, medium, &Unshadowed);
            let expected = check_lists(&cpu, of, &emitters, medium, &Unshadowed);
            differing += differ(&found, &expected, &expected);
            points_lit += points.len();
        }
    }
    println!("{differing} of {points_lit} points");
    let allowed = Allowed::GpuDirectLightPoints.error() * points_lit as f64;
    assert!(differing as f64 <= allowed, "{differing} of {points_lit}");
}

#[cfg(feature = "shadow-dag")]
#[test]
fn shadows_on_points_of_both_backends_are_alike_whatever_the_lists() {
    use crate::methods::many_lights::tests::shadowed::plates;
    use crate::precomputed::{BakedShadow, BakedShadows, FilterSize};

    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(2);
    let cpu = Cpu::new();
    let (mut points_lit, mut differing, mut in_shadow) = (0, 0, 0);
    for set in 0..6 {
        let rays = rays(&mut random);
        let emitters = lights(&mut random, &rays, 9);
        let points = points(&mut random, &rays);
        let shadows = plates(&mut random, &rays, &emitters);
        let owned: Vec<BakedShadow> = shadows.iter().map(|shadow| (**shadow).clone()).collect();
        let size = FilterSize::new([1, 3, 9][set % 3]).unwrap();
        let here = BakedShadows::upload(&owned, &cpu).unwrap();
        let there = BakedShadows::upload(&owned, &gpu).unwrap();
        assert!(there.filtered(size).lights_per_dispatch() >= 30);
        let of = (&rays[..], &points[..]);
        let found = check_lists(&gpu, of, &emitters, None, &there.filtered(size));
        let expected = check_lists(&cpu, of, &emitters, None, &here.filtered(size));
        let open = check_lists(&cpu, of, &emitters, None, &Unshadowed);
        differing += differ(&found, &expected, &open);
        in_shadow += differ(&expected, &open, &open);
        points_lit += points.len();
        // One light at a time is what the filter of that light tells.
        let alone: Vec<_> = owned.iter().map(|shadow| shadow.filtered(size)).collect();
        let found = check_lists(&cpu, of, &emitters, None, &alone);
        assert!(bits(&found) == bits(&expected));
    }
    println!("{differing} of {points_lit} points, {in_shadow} in shadow");
    let allowed = Allowed::GpuFilteredPoints.error() * points_lit as f64;
    assert!(differing as f64 <= allowed, "{differing} of {points_lit}");
    assert!(in_shadow > 100);
}

/// What stays is in precomputed shadows, what moves in maps.
#[cfg(feature = "shadow-dag")]
#[test]
fn shadows_of_what_stays_and_of_what_moves_are_alike_on_both_backends() {
    use crate::methods::many_lights::tests::shadowed::{plates, scattered_plates};
    use crate::precomputed::{BakedShadow, BakedShadows, FilterSize};
    use crate::shadow_map::{Casters, MapsOfMany};
    use crate::visibility::Both;

    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(3);
    let cpu = Cpu::new();
    let (mut points_lit, mut differing, mut in_shadow) = (0, 0, [0; 2]);
    for set in 0..6 {
        let rays = rays(&mut random);
        let mut emitters = lights(&mut random, &rays, 9);
        emitters.insert(4, Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap());
        let points = points(&mut random, &rays);
        let shadows = plates(&mut random, &rays, &emitters);
        let moving = scattered_plates(&mut random, &rays);
        let owned: Vec<BakedShadow> = shadows.iter().map(|shadow| (**shadow).clone()).collect();
        let size = FilterSize::new([1, 3, 9][set % 3]).unwrap();
        let here = BakedShadows::upload(&owned, &cpu).unwrap();
        let there = BakedShadows::upload(&owned, &gpu).unwrap();
        let casters = Casters::upload(&cpu, &moving).unwrap();
        let maps = MapsOfMany::render(&cpu, &casters, &emitters, 64).unwrap();
        let maps = maps.with_biases(&[0.5, 2.0]);
        let maps_there = maps.upload(&gpu).unwrap();
        let of = (&rays[..], &points[..]);
        let mapped = maps.filtered(size.width());
        assert!(mapped.lights_per_dispatch() >= 100);
        let both = Both(here.filtered(size), mapped);
        let both_there = Both(there.filtered(size), maps_there.filtered(size.width()));
        let found = check_lists(&gpu, of, &emitters, None, &both_there);
        let expected = check_lists(&cpu, of, &emitters, None, &both);
        let baked = check_lists(&cpu, of, &emitters, None, &here.filtered(size));
        let open = check_lists(&cpu, of, &emitters, None, &Unshadowed);
        differing += differ(&found, &expected, &open);
        in_shadow[0] += differ(&baked, &open, &open);
        in_shadow[1] += differ(&expected, &baked, &open);
        points_lit += points.len();
    }
    println!("{differing} of {points_lit} points, {in_shadow:?} in shadow");
    let allowed = Allowed::GpuFilteredPoints.error() * points_lit as f64;
    assert!(differing as f64 <= allowed, "{differing} of {points_lit}");
    assert!(in_shadow.iter().all(|points| *points > 100));
}
