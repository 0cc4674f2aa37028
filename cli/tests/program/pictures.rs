//! What is in a picture: of a bare model, from where one wants to see it, smooth, and
//! in layers.

use std::collections::BTreeMap;
use std::path::Path;

use crate::common::{notes, run, succeeds};

/// A box of 2 x 1 x 1 m, and how far it is from the origin.
fn cuboid(offset: [f64; 3]) -> String {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n\
         property double z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for corner in 0..8 {
        let at = |axis: usize| f64::from(corner >> axis & 1) * [2.0, 1.0, 1.0][axis] + offset[axis];
        text += &format!("{} {} {}\n", at(0), at(1), at(2));
    }
    text + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"
}

/// The channels of an EXR file by name.
fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let layer = &image.layer_data[0];
    let list = layer.channel_data.list.iter();
    list.map(|channel| {
        let values = channel.sample_data.values_as_f32().collect();
        (channel.name.to_string(), values)
    })
    .collect()
}

fn red(place: &Path, arguments: &[&str]) -> Vec<f32> {
    let render = [&["render"][..], arguments, &["-o", "red.exr"]].concat();
    succeeds(place, &render);
    channels(&place.join("red.exr")).remove("R").unwrap()
}

const VACUUM: [&str; 4] = ["--sigma-s", "0", "--sigma-a", "0"];

#[test]
fn a_bare_model_fills_its_picture_is_lit_from_the_front_and_throws_a_shadow() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("box.ply"), cuboid([0.0; 3])).unwrap();
    let size = ["box.ply", "--size", "64x36"];
    let alone = red(
        place.path(),
        &[&size[..], &VACUUM, &["--no-ground"]].concat(),
    );
    let lit = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| {
        let pixels = rows.flat_map(|row| columns.clone().map(move |column| 64 * row + column));
        pixels.filter(|pixel| alone[*pixel] > 0.0).count()
    };
    // In one direction it comes near to both borders, and it never leaves the picture.
    let border = lit(0..1, 0..64) + lit(35..36, 0..64) + lit(0..36, 0..1) + lit(0..36, 63..64);
    assert_eq!(border, 0);
    let (top, bottom) = (lit(0..6, 0..64), lit(30..36, 0..64));
    let (left, right) = (lit(0..36, 0..8), lit(0..36, 56..64));
    assert!(
        (top > 0 && bottom > 0) || (left > 0 && right > 0),
        "{top} {bottom} {left} {right}"
    );
    // Each of the three faces that are seen is lit: it is no silhouette.
    assert!(lit(0..36, 0..64) > 64 * 36 / 5, "{}", lit(0..36, 0..64));

    let standing = red(place.path(), &[&size[..], &VACUUM].concat());
    let ground: Vec<usize> = (0..64 * 36).filter(|pixel| alone[*pixel] == 0.0).collect();
    let lit = ground
        .iter()
        .filter(|pixel| standing[**pixel] > 0.0)
        .count();
    let shadow = ground[ground.len() / 2..]
        .iter()
        .filter(|pixel| standing[**pixel] == 0.0);
    assert!(lit > ground.len() / 3, "{lit} of {}", ground.len());
    assert!(shadow.count() > 10);
    for pixel in 0..64 * 36 {
        assert!(
            alone[pixel] == 0.0 || standing[pixel] == alone[pixel],
            "{pixel}"
        );
    }
}

#[test]
fn files_that_bring_a_light_or_a_camera_get_no_ground() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("box.ply"), cuboid([0.0; 3])).unwrap();
    let render = ["render", "box.ply", "--size", "8x8", "-o", "a.png"];
    assert!(notes(place.path(), &render).contains("laid ground"));
    let without = [&render[..], &["--no-ground"]].concat();
    assert!(!notes(place.path(), &without).contains("laid ground"));
    let embedded = ["render", "fence", "--size", "8x8", "-o", "a.png"];
    assert!(!notes(place.path(), &embedded).contains("laid ground"));
}

#[test]
fn a_camera_and_a_light_stand_where_they_are_put() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("box.ply"), cuboid([0.0; 3])).unwrap();
    // Straight at the front, which fills 2 of 4 m of the picture's width.
    let look = ["box.ply", "--size", "32x32", "--no-ground", "--camera"];
    let at = |camera: &'static str, light: &'static str| {
        red(
            place.path(),
            &[&look[..], &[camera, "--light-at", light], &VACUUM].concat(),
        )
    };
    let picture = at("1,0.5,3,1,0.5,1,90", "1,0.5,3");
    let lit = picture.iter().filter(|value| **value > 0.0).count();
    assert_eq!(lit, 16 * 8);
    let behind = at("1,0.5,3,1,0.5,1,90", "1,0.5,-3");
    assert!(behind.iter().all(|value| *value == 0.0));

    // Coordinates are those of the file, although the scene is moved.
    let far = [500_000.37, 100.0, 4_649_776.22];
    std::fs::write(place.path().join("far.ply"), cuboid(far)).unwrap();
    let look = ["far.ply", "--size", "32x32", "--no-ground"];
    let camera = "500001.37,100.5,4649779.22,500001.37,100.5,4649777.22,90";
    let put = [
        "--camera",
        camera,
        "--light-at",
        "500001.37,100.5,4649779.22",
    ];
    let moved = red(place.path(), &[&look[..], &put, &VACUUM].concat());
    for (a, b) in picture.iter().zip(&moved) {
        assert!((a - b).abs() <= 1e-4 * a, "{a} {b}");
    }
    for bad in ["1,2,3", "0,0,0,0,0,0", "nan,0,0,0,0,0", "0,0,0,0,0,1,0"] {
        let arguments = ["render", "box.ply", "-o", "a.png", "--camera", bad];
        let output = run(place.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{bad}: {message}");
        assert!(message.contains("--camera"), "{bad}: {message}");
    }
}

#[test]
fn several_rays_per_pixel_are_the_mean_of_a_finer_picture() {
    let place = tempfile::tempdir().unwrap();
    let fine = red(place.path(), &["fence", "--size", "32x16"]);
    let smooth = red(place.path(), &["fence", "--size", "16x8", "--spp", "4"]);
    for (pixel, value) in smooth.iter().enumerate() {
        let (row, column) = (pixel / 16 * 2, pixel % 16 * 2);
        let at = |y: usize, x: usize| f64::from(fine[(row + y) * 32 + column + x]);
        let mean = 0.25 * (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1));
        assert!(
            (f64::from(*value) - mean).abs() <= 1e-5 * mean,
            "{value} {mean}"
        );
    }
    for (spp, size) in [("3", "8x8"), ("0", "8x8"), ("64", "4096x4096")] {
        let arguments = [
            "render", "fence", "-o", "a.png", "--spp", spp, "--size", size,
        ];
        let output = run(place.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("--spp"), "{message}");
    }
}

#[test]
fn layers_add_up_to_the_picture() {
    let place = tempfile::tempdir().unwrap();
    // Two lights; area lights glow, and one of these is four emitters.
    for (scene, lights) in [("stiff", 2), ("area-light", 1)] {
        let more = [
            "--lights",
            "4",
            "--surface-scattering",
            "unshadowed",
            "--spp",
            "4",
        ];
        let options = [&[scene, "--size", "16x9"][..], &more].concat();
        let plain = red(place.path(), &options);
        let layers = [&["render"][..], &options, &["--layers", "-o", "a.exr"]].concat();
        succeeds(place.path(), &layers);
        let channels = channels(&place.path().join("a.exr"));
        let get = |name: &str| &channels[&format!("{name}.R")];
        let of = |part: &str| {
            let end = format!(".{part}.R");
            let all = channels
                .iter()
                .filter(|(name, _)| name.starts_with("light.") && name.ends_with(&end));
            all.map(|(_, values)| values).collect::<Vec<_>>()
        };
        assert_eq!((of("surfaces").len(), of("fog").len()), (lights, lights));
        let close = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.abs().max(1e-6);
        for pixel in 0..16 * 9 {
            let (surfaces, fog) = (get("surfaces")[pixel], get("fog")[pixel]);
            assert!(close(channels["R"][pixel], surfaces + fog));
            assert!(close(channels["R"][pixel], plain[pixel]), "{scene} {pixel}");
            let sum = |part: &str| of(part).iter().map(|values| values[pixel]).sum::<f32>();
            let others = get("emitted")[pixel] + get("indirect")[pixel];
            assert!(close(surfaces, others + sum("surfaces")), "{scene} {pixel}");
            assert!(close(fog, sum("fog")), "{scene} {pixel}");
            let share = get("transmittance")[pixel];
            assert!((0.0..=1.0).contains(&share), "{share}");
        }
        assert!(get("transmittance").iter().any(|share| *share > 0.0));
        let glows = get("emitted").iter().any(|value| *value > 0.0);
        assert_eq!(glows, scene == "area-light");
    }
    let output = run(
        place.path(),
        &["render", "fence", "--layers", "-o", "a.png"],
    );
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("--layers needs an EXR file"), "{message}");
}

#[test]
fn surfaces_have_the_shadows_of_the_voxels_where_that_is_asked_for() {
    let place = tempfile::tempdir().unwrap();
    let surfaces = |method: &str, way: &str| {
        let scene = ["render", "pergola", "--size", "48x27", "--layers"];
        let how = ["--method", method, "--quality", "32", "--surface-shadows"];
        let render = [&scene[..], &how, &[way, "-o", "layers.exr"]].concat();
        succeeds(place.path(), &render);
        channels(&place.path().join("layers.exr"))
            .remove("surfaces.G")
            .unwrap()
    };
    let traced = surfaces("area-average", "traced");
    let mean = traced.iter().sum::<f32>() / traced.len() as f32;
    let off = |found: &[f32]| {
        let differences = found.iter().zip(&traced).map(|(a, b)| (a - b).abs());
        differences.sum::<f32>() / traced.len() as f32 / mean
    };
    let [nearest, smooth] = ["voxels", "interpolated"].map(|way| surfaces("area-average", way));
    println!("{} {}", off(&nearest), off(&smooth));
    // Borders of shadows are two or three voxels away from where they should be.
    assert!(nearest != traced && smooth != nearest);
    assert!(off(&nearest) < 0.1 && off(&smooth) < 0.1);
    // A method of fewer rays has the same surfaces, one without voxels none.
    assert_eq!(surfaces("area-runs 3x3", "voxels"), nearest);
    let place = place.path();
    let march = ["render", "pergola", "--size", "8x8", "-o", "a.png"];
    let march = [
        &march[..],
        &[
            "--method",
            "march x midpoint",
            "--surface-shadows",
            "voxels",
        ],
    ]
    .concat();
    let output = run(place, &march);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success());
    assert!(message.contains("no shadows on surfaces"), "{message}");
}

/// A wall, a camera before it and a lamp between the two whose range ends before the wall.
fn lamp_before_a_wall(place: &Path) {
    let corners = [-8.0_f32, -8.0, 0.0, 8.0, -8.0, 0.0, 0.0, 8.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|n| n.to_le_bytes()).collect();
    std::fs::write(place.join("wall.bin"), bytes).unwrap();
    let scene = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 6]},
            {"translation": [0.5, 0.2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights":
            [{"type": "point", "intensity": 100, "range": 2.5}]}},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "wall.bin"}]}"#;
    std::fs::write(place.join("wall.gltf"), scene).unwrap();
}

#[test]
fn the_shadows_of_a_lamp_with_nothing_in_its_way_are_left_out() {
    let place = tempfile::tempdir().unwrap();
    lamp_before_a_wall(place.path());
    let size = ["wall.gltf", "--size", "48x27", "--sigma-s", "0.1"];
    let with = |more: &[&'static str]| red(place.path(), &[&size[..], more].concat());
    let exact = with(&["--all-shadows"]);
    assert!(exact.iter().any(|light| *light > 0.0));
    assert!(with(&[]) == exact, "of exact visibility not a bit changes");
    let error = |picture: &[f32]| {
        let errors = picture.iter().zip(&exact).map(|(a, b)| (a - b).abs() / b);
        errors.filter(|e| e.is_finite()).fold(0.0, f32::max)
    };
    let march = [
        "--visibility",
        "march",
        "--airlight",
        "midpoint",
        "--samples",
        "4",
    ];
    let forced = with(&[&march[..], &["--all-shadows"]].concat());
    let planned = with(&march);
    assert!(error(&planned) < 4e-4, "{}", error(&planned));
    assert!(error(&forced) > 0.01, "{}", error(&forced));

    let render = [&["render"][..], &size, &["-o", "a.png"]].concat();
    let said = notes(place.path(), &render);
    let left_out = "left out: shadows in the air of emitter 0 (no caster is between the light and \
                    the air of the view; saves 1296 rays";
    assert!(said.contains(left_out), "{said}");
    let said = notes(place.path(), &[&render[..], &["--all-shadows"]].concat());
    assert!(!said.contains("left out"), "{said}");
    let compare = [
        "compare",
        "wall.gltf",
        "--quick",
        "--plan",
        "--backend",
        "cpu",
    ];
    let said = succeeds(place.path(), &compare);
    assert!(
        said.contains("left out: shadows in the air of emitter 0, by `render` ("),
        "{said}"
    );
}
