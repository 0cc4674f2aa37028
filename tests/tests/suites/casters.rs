//! Casters that are not solid: every method, on every backend, in every hard case.

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::suite::{self, Subject};
use glam::{Vec2, Vec3};
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Cpu, Download};
use lighting::methods::{Entry, Frame, FrameInputs, Registry, Store, Verdict};
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{AlphaMode, Filter, Geometry, Material, Sampler, Scene, Texture, Wrap};
use lighting::surface;
use reference::hard_cases::{CasterCase, caster_cases};
use reference::metrics::image_error;
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(heavy:
    what_is_as_good_as_solid_or_absent_is_so_to_every_method,
    maps_and_marches_see_masks_and_panes,
);
crepuscular_tests::on_every_backend!(traced:
    exact_pictures_are_the_reference,
);

/// Texels per side of shadow maps.
const MAP: u32 = 512;

fn test_scene(case: &CasterCase, size: [u32; 2]) -> TestScene {
    TestScene::of(case.name, case.scene.clone(), size[0], size[1])
}

/// A masked caster and its twin are known to be the same triangles by what a map
/// shows, not by their list: rounding in another order.
fn what_is_as_good_as_solid_or_absent_is_so_to_every_method<B: Subject>(backend: &B) {
    let registry = Registry::standard();
    // What integrates the lit parts knows nothing of casters: one pair for each source.
    let mut sources = Vec::new();
    let mut is_new = |entry: &&Entry| {
        let source = entry.halves().map(|[(source, _), _]| source);
        let is_new = source.is_none() || !sources.contains(&source);
        sources.push(source);
        is_new
    };
    let entries: Vec<&Entry> = registry.compared().filter(&mut is_new).collect();
    for case in caster_cases() {
        let Some(twin) = case.twin.clone() else {
            continue;
        };
        let scenes = [case.scene, twin].map(|scene| TestScene::of(case.name, scene, 16, 9));
        let hosts = [Store::new(), Store::new()];
        let [own, twin] = [0, 1].map(|i| inputs(&scenes[i], 128, &hosts[i]));
        for entry in &entries {
            let about = entry.about();
            if entry.on::<B>().is_none()
                || matches!(entry.method().applies(&own), Verdict::Impossible(_))
            {
                continue;
            }
            let [Some(found), Some(expected)] =
                [own, twin].map(|inputs| image(backend, inputs, entry, about.quick[0]).unwrap())
            else {
                continue;
            };
            let most = expected.iter().map(|light| light[0]).fold(0.0, f32::max);
            for (found, expected) in found.iter().zip(&expected) {
                for channel in 0..3 {
                    let off = (found[channel] - expected[channel]).abs();
                    assert!(
                        off <= 1e-5 * most,
                        "{}, {}: {found:?} {expected:?}",
                        case.name,
                        about.name
                    );
                }
            }
        }
    }
}

/// The error of a method with maps of so many texels.
fn error<B: Subject>(
    backend: &B,
    scene: &TestScene,
    entry: &Entry,
    map: u32,
    quality: u32,
    truth: &reference::metrics::Reference,
) -> Option<f64> {
    let host = Store::new();
    let inputs = inputs(scene, map, &host);
    if entry.method().applies(&inputs) != Verdict::Applies {
        return None;
    }
    let image = image(backend, inputs, entry, quality).unwrap()?;
    assert!(image.iter().flatten().all(|light| light.is_finite()));
    Some(image_error(&image, truth).rmse)
}

/// Marches through shadow maps where nothing is see-through, marches through maps of
/// transmittance everywhere.
fn maps_and_marches_see_masks_and_panes<B: Subject>(backend: &B) {
    let registry = Registry::standard();
    let size = [24, 14];
    let is_empty = |case: &CasterCase| case.name == "alpha 0";
    let empty = caster_cases().into_iter().find(is_empty).unwrap();
    let empty = test_scene(&empty, size).truth();
    let empty: Vec<[f32; 4]> = empty
        .radiance
        .iter()
        .map(|light| [light[0] as f32, light[1] as f32, light[2] as f32, 0.0])
        .collect();
    for case in caster_cases() {
        let scene = test_scene(&case, size);
        let truth = scene.truth();
        // How much it matters that there is a caster.
        let effect = image_error(&empty, &truth).rmse;
        for (name, quality) in [
            ("march x midpoint", 256),
            ("per-voxel x gauss-1", 256),
            ("translucent x gauss-1", 128),
        ] {
            let entry = registry.find(name).unwrap();
            let Some(error) = error(backend, &scene, &entry, MAP, quality, &truth) else {
                continue;
            };
            println!("{}, {name}: {error:.4} of {effect:.4}", case.name);
            assert!(
                error <= Allowed::CasterImage.error(),
                "{}, {name}: {error}",
                case.name
            );
        }
    }
}

fn exact_pictures_are_the_reference<B: Subject>(backend: &B) {
    let entry = Registry::standard()
        .pair("exact", "quadrature", None)
        .unwrap();
    for case in caster_cases() {
        let scene = test_scene(&case, [20, 12]);
        let host = Store::new();
        let image = image(backend, inputs(&scene, MAP, &host), &entry, 5)
            .unwrap()
            .unwrap();
        let error = image_error(&image, &scene.truth()).rmse;
        println!("{}: {error:.1e}", case.name);
        // The quadrature's own tolerance comes on top. A film varies, and so does a pane
        // in steps.
        let allowed = if case.name.contains("film") || case.name.contains("varies") {
            Allowed::ExactFilm
        } else {
            Allowed::ExactImage
        };
        assert!(error <= allowed.error() + 1e-5, "{}: {error}", case.name);
    }
}

/// What sees panes on a GPU, and what is before the eye with everything else.
#[test]
fn both_backends_agree_behind_masks_and_panes_but_for_rays_at_an_edge() {
    let Some(gpu) = suite::gpu() else { return };
    let (cpu, registry) = (Cpu::new(), Registry::standard());
    let unshadowed = registry.pair("none", "gauss", None).unwrap();
    for case in caster_cases() {
        let scene = test_scene(&case, [32, 18]);
        let host = Store::new();
        let inputs = inputs(&scene, 128, &host);
        let scale = image(&cpu, inputs, &unshadowed, 8).unwrap().unwrap();
        for (visibility, airlight, detail) in [
            ("none", "gauss", None),
            ("exact", "gauss", None),
            ("translucent", "gauss", Some(1)),
            ("translucent", "table", None),
        ] {
            let entry = &registry.pair(visibility, airlight, detail).unwrap();
            let name = entry.about().name;
            let method = entry.on::<Gpu<Queued>>().unwrap();
            let quality = entry.about().usual;
            let expected = image(&cpu, inputs, entry, quality).unwrap().unwrap();
            let store = Store::new();
            let frame = Frame::new(&gpu, inputs, &store).unwrap();
            let mut radiance = gpu.zeros::<[f32; 4]>(scene.rays.len()).unwrap();
            method.add_radiance(&frame, quality, &mut radiance).unwrap();
            let actual = gpu.download(&radiance).unwrap();
            let differs = |i: &usize| {
                (0..3).any(|c| {
                    let (e, g) = (expected[*i][c], actual[*i][c]);
                    let scale = scale[*i][c].max(e).max(f32::MIN_POSITIVE);
                    f64::from((e - g).abs())
                        > 20.0 * Allowed::GpuRadiance.error() * f64::from(scale)
                })
            };
            let different = (0..expected.len()).filter(differs).count();
            println!(
                "{}, {name}: {different} of {} differ",
                case.name,
                expected.len()
            );
            assert!(
                different as f64 <= 2.0 * Allowed::GpuSmokeRays.error() * expected.len() as f64,
                "{}, {name}: {different}",
                case.name
            );
        }
    }
}

/// The picture of exact visibility.
fn exact(scene: &TestScene) -> Vec<[f32; 4]> {
    let entry = Registry::standard()
        .pair("exact", "quadrature", None)
        .unwrap();
    let host = Store::new();
    image(&Cpu::new(), inputs(scene, 64, &host), &entry, 5)
        .unwrap()
        .unwrap()
}

/// A room whose card is of this material, and the lamp alone.
fn room_with(material: Material) -> Scene {
    let mut scene = caster_cases().swap_remove(0).scene;
    scene.materials[1] = material;
    scene
}

fn pane(transmission: f32, base_color: Vec3) -> Material {
    Material {
        base_color,
        transmission,
        ..Material::default()
    }
}

/// Light behind two panes at the same place is that behind one that lets the product
/// of both through.
#[test]
fn panes_multiply() {
    let (a, b) = (Vec3::new(0.9, 0.5, 0.7), Vec3::new(0.4, 0.8, 0.6));
    let mut two = room_with(pane(1.0, a));
    let mut second = two.instances[1].clone();
    // As far off as coordinates can tell apart and fog cannot.
    second.transform.translation.z -= 1e-4;
    second.mesh = two.meshes.len();
    two.instances.push(second);
    let mut mesh = two.meshes[1].clone();
    mesh.material = Some(two.materials.len());
    two.meshes.push(mesh);
    two.materials.push(pane(1.0, b));
    let one = room_with(pane(1.0, a * b));
    let of = |scene| exact(&TestScene::of("panes", scene, 20, 12));
    let (two, one) = (of(two), of(one));
    let most = one.iter().map(|light| light[0]).fold(0.0, f32::max);
    for (pixel, (two, one)) in two.iter().zip(&one).enumerate() {
        for channel in 0..3 {
            let off = (two[channel] - one[channel]).abs();
            assert!(off <= 3e-4 * most, "{pixel}: {two:?} {one:?}");
        }
    }
}

/// What a mask takes away and what its negative does are what the card does, where the
/// eye does not look through it.
#[test]
fn a_mask_and_its_negative_are_the_card() {
    let masked = |is_negative: bool| {
        let texels = (0..64_u32).map(|i| (i * 37 % 64 < 30) != is_negative);
        let alpha = texels
            .map(|is_there| f32::from(u8::from(is_there)))
            .collect();
        let texture = Texture::new(8, 8, vec![Vec3::ONE; 64]).unwrap();
        room_with(Material {
            base_color_texture: Some(texture.with_alpha(alpha).unwrap().with_sampler(Sampler {
                wrap: [Wrap::Clamp; 2],
                filter: Filter::Nearest,
            })),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        })
    };
    let clear = Material {
        alpha: AlphaMode::Mask { cutoff: 2.0 },
        ..Material::default()
    };
    let scenes = [
        masked(false),
        masked(true),
        room_with(Material::default()),
        room_with(clear),
    ];
    let scenes = scenes.map(|scene| TestScene::of("masks", scene, 20, 12));
    let beside: Vec<bool> = scenes[2]
        .hits
        .iter()
        .map(|hit| hit.is_none_or(|hit| hit.triangle < 6))
        .collect();
    assert!(beside.iter().filter(|beside| **beside).count() > 100);
    let [mask, negative, card, none] = scenes.map(|scene| exact(&scene));
    let mut taken = 0.0;
    for pixel in 0..mask.len() {
        if !beside[pixel] {
            continue;
        }
        let light = |of: &[[f32; 4]]| f64::from(of[pixel][1]);
        let off = light(&mask) + light(&negative) - light(&card) - light(&none);
        assert!(off.abs() <= 4e-5 * light(&none), "{pixel}: {off}");
        taken += light(&none) - light(&card);
    }
    assert!(taken > 0.0);
}

/// Surfaces and air of a card with a texture that leaves half of it, and of half a card.
#[test]
fn a_masked_card_is_the_card_that_is_cut() {
    let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
    let texture = texture.with_alpha(vec![1.0, 0.0]).unwrap();
    let cutout = room_with(Material {
        base_color_texture: Some(texture.with_sampler(Sampler {
            wrap: [Wrap::Clamp; 2],
            filter: Filter::Linear,
        })),
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::default()
    });
    let mut cut = room_with(Material::default());
    for corner in &mut cut.meshes[1].positions {
        corner.x = corner.x.min(0.0);
    }
    let whole = room_with(Material::default());
    let picture = |scene: &Scene| {
        let test_scene = TestScene::of("card", scene.clone(), 65, 65);
        let geometry = Geometry::new(scene).unwrap();
        let tracer = Tracer::new(&geometry);
        let view = View::new(&Cpu::new(), &test_scene.camera, &tracer, 65, 65).unwrap();
        let (emitters, medium) = (&test_scene.emitters, Some(&test_scene.medium));
        let surfaces = surface::radiance(
            &Cpu::new(),
            &view,
            scene,
            &geometry,
            &tracer,
            emitters,
            medium,
        );
        let air = exact(&test_scene);
        let sum = |(a, b): (&[f32; 4], &[f32; 4])| f64::from(a[0]) + f64::from(b[0]);
        surfaces.iter().zip(&air).map(sum).collect::<Vec<f64>>()
    };
    let mean = |picture: &[f64]| picture.iter().sum::<f64>() / picture.len() as f64;
    let [cutout, cut, whole] = [&cutout, &cut, &whole].map(picture);
    let others = cutout
        .iter()
        .zip(&cut)
        .filter(|(a, b)| (*a - *b).abs() > 1e-4 * mean(&cut))
        .count();
    // Rays and shadow rays on the rim.
    assert!(others <= 4, "{others} pixels differ");
    assert!((mean(&cutout) / mean(&cut) - 1.0).abs() < 1e-3);
    assert!((mean(&whole) / mean(&cut) - 1.0).abs() > 0.01);
}

/// Notes and verdicts tell what does not see panes.
#[test]
fn what_sees_no_panes_says_so() {
    let case = caster_cases()
        .into_iter()
        .find(|case| case.name == "a coloured pane")
        .unwrap();
    let scene = test_scene(&case, [4, 4]);
    let host = Store::new();
    let inputs: FrameInputs<'_> = inputs(&scene, 32, &host);
    for entry in Registry::standard().compared() {
        let about = entry.about();
        let notes = entry.method().notes(&inputs);
        let says_so = notes.iter().any(|note| note.contains("see-through"));
        let all = ["exact", "translucent", "area-rays", "area-traced-runs"];
        // Those of smoke do through maps of curves, and these two have none.
        let without_curves = ["media-unshadowed", "media-double-march"];
        let has_curves =
            about.name.starts_with("media-") && !without_curves.contains(&&*about.name);
        let sees = has_curves || all.iter().any(|name| about.name.starts_with(name));
        assert_eq!(says_so, !sees, "{}: {notes:?}", about.name);
        if let Verdict::Pointless(reason) = entry.method().applies(&inputs) {
            assert!(!sees || !reason.contains("see-through"), "{reason}");
        }
    }
    // A scene's fields may be anything; what is out of its domain is refused by name.
    let mut bad = case.scene;
    bad.meshes[1].transmission_coordinates = vec![Vec2::ZERO];
    let error = Geometry::new(&bad).unwrap_err().to_string();
    assert!(error.contains("transmission"), "{error}");
}
