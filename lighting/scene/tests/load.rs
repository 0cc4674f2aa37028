//! Scene files on disk.

use std::fs;
use std::path::{Path, PathBuf};

use scene::load::{LoadError, LoadOptions, scene_from_path};
use scene::{Geometry, Light, Scene};

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 1 0 0 0 1 0 3 0 1 2\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data/the%20buffer.bin"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]}"#;

fn triangle() -> Vec<u8> {
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect()
}

#[test]
fn the_contents_decide_what_a_file_is() {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents) in [
        ("a.ply", PLY),
        ("b.glb", PLY),
        ("c", PLY),
        ("d.ply", GLTF),
        ("e.x", GLTF),
    ] {
        let path = folder.path().join(name);
        fs::create_dir_all(folder.path().join("data")).unwrap();
        fs::write(folder.path().join("data/the buffer.bin"), triangle()).unwrap();
        fs::write(&path, contents).unwrap();
        let loaded = scene_from_path(&path, &LoadOptions::default()).unwrap();
        assert_eq!(Geometry::new(&loaded.scene).unwrap().triangles().len(), 1);
        assert_eq!(loaded.scene.name, name.split('.').next().unwrap());
    }
}

#[test]
fn a_missing_or_short_buffer_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, GLTF).unwrap();
    let error = scene_from_path(&path, &LoadOptions::default()).unwrap_err();
    assert!(matches!(error, LoadError::Io { .. }));
    assert!(error.to_string().contains("the buffer.bin"), "{error}");

    fs::create_dir(folder.path().join("data")).unwrap();
    fs::write(folder.path().join("data/the buffer.bin"), [0; 35]).unwrap();
    let error = scene_from_path(&path, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("buffer 0 needs 36 bytes"), "{error}");
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents, cause) in [
        ("empty.glb", &b""[..], "only 0"),
        ("half.glb", b"gl", "malformed"),
        (
            "text.txt",
            b"hello",
            "neither glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB nor OpenVDB",
        ),
        ("text.ply", b"hello\n", "\"ply\""),
        ("text.gltf", b"hello", "malformed"),
        (
            "empty.gltf",
            b"{\"asset\":{\"version\":\"2.0\"}}",
            "no triangles",
        ),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, contents).unwrap();
        let error = scene_from_path(&path, &LoadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains(cause), "{name}: {error}");
    }
    assert!(scene_from_path(folder.path(), &LoadOptions::default()).is_err());
    let error = scene_from_path(&folder.path().join("none.glb"), &LoadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("none.glb"), "{error}");
}

/// Scenes that others made, beside the workspace; they are no part of it.
fn others(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let path = folder.join(name);
    if !path.exists() {
        println!("skipped: there is no {}", path.display());
        return None;
    }
    Some(path)
}

fn load(path: &Path) -> (Scene, Geometry) {
    let loaded = scene_from_path(path, &LoadOptions::default()).expect("a sound file");
    println!("{}: {:?}", path.display(), loaded.notes);
    let geometry = Geometry::new(&loaded.scene).expect("sound geometry");
    for light in &loaded.scene.lights {
        light.emitters(16).expect("sound lights");
    }
    (loaded.scene, geometry)
}

#[test]
fn cities_keep_their_triangles_lights_and_camera() {
    for (name, lights, kind) in [
        ("city_sun.glb", 1, "directional"),
        ("city_point.glb", 1, "point"),
        ("city_165_spots.glb", 165, "spot"),
    ] {
        let Some(path) = others(name) else {
            continue;
        };
        let (scene, geometry) = load(&path);
        assert_eq!(geometry.triangles().len() + geometry.dropped(), 135_264);
        assert!(scene.camera.is_some());
        assert_eq!(scene.lights.len(), lights);
        for light in &scene.lights {
            assert_eq!(light.kind(), kind);
            if let Light::Spot(spot) = light {
                assert!(spot.range.is_finite() && spot.cone.outer > spot.cone.inner);
            }
        }
    }
}

#[test]
fn models_with_textures_and_external_buffers_load() {
    for (name, triangles) in [
        ("building_A", 828),
        ("building_C", 1020),
        ("streetlight", 176),
        ("watertower", 146),
    ] {
        let Some(path) = others(&format!("kaykit/{name}.gltf")) else {
            continue;
        };
        let (scene, geometry) = load(&path);
        assert_eq!(geometry.triangles().len() + geometry.dropped(), triangles);
        assert!(!scene.meshes[0].texture_coordinates.is_empty());
        assert!(scene.materials[0].base_color_texture.is_some());
    }
}

#[test]
fn scanned_meshes_have_the_faces_their_headers_promise() {
    for (name, triangles) in [("spot_6k.ply", 5_856), ("skull_100k.ply", 100_002)] {
        let Some(path) = others(name) else {
            continue;
        };
        let (_, geometry) = load(&path);
        assert_eq!(geometry.triangles().len() + geometry.dropped(), triangles);
    }
}
