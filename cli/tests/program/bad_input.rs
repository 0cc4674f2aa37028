//! Whatever is wrong, the program says so in a few lines, returns 2 and leaves
//! nothing behind.

use crate::common::{self, run};

/// Runs in a folder with `files` and expects the cause in the message.
fn fails(files: &[(&str, &[u8])], arguments: &[&str], cause: &str) {
    let place = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(place.path().join(name), content).unwrap();
    }
    common::fails(place.path(), arguments, cause);
}

/// Both commands on one bad scene file.
fn fails_as_scene(files: &[(&str, &[u8])], cause: &str) {
    let scene = files[0].0;
    fails(files, &["compare", scene, "--quick"], cause);
    fails(files, &["render", scene, "-o", "out.png"], cause);
}

const PLY_TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A GLB file around `json`, without a binary chunk.
fn glb(json: &str) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend((20 + json.len() as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json);
    file
}

/// One triangle whose buffer has the address `uri`.
fn gltf(uri: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36, "uri": "{uri}"}}]}}"#
    )
}

#[test]
fn a_truncated_glb() {
    let whole = glb(&gltf("missing.bin"));
    for length in [0, 3, 11, 19, 30, whole.len() - 1] {
        fails_as_scene(&[("a.glb", &whole[..length])], "a.glb");
    }
}

#[test]
fn a_missing_buffer_file() {
    let text = gltf("missing.bin");
    fails_as_scene(&[("a.gltf", text.as_bytes())], "missing.bin");
}

#[test]
fn positions_that_are_not_numbers() {
    let text = PLY_TRIANGLE.replace("\n1 0 0\n", "\nnan 0 0\n");
    fails_as_scene(&[("a.ply", text.as_bytes())], "nan");
}

#[test]
fn triangles_without_area_only() {
    let text = PLY_TRIANGLE.replace("\n0 1 0\n", "\n2 0 0\n");
    fails_as_scene(&[("a.ply", text.as_bytes())], "no triangles");
}

#[test]
fn indices_out_of_range() {
    let text = PLY_TRIANGLE.replace("3 0 1 2", "3 0 1 7");
    fails_as_scene(&[("a.ply", text.as_bytes())], "7");
}

#[test]
fn a_header_that_promises_four_billion_vertices() {
    let text = PLY_TRIANGLE.replace("vertex 3", "vertex 4000000000");
    fails_as_scene(&[("a.ply", text.as_bytes())], "4000000000");
}

#[test]
fn an_empty_scene() {
    let text = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0}"#;
    fails_as_scene(&[("a.gltf", text.as_bytes())], "no triangles");
    fails_as_scene(&[("a.ply", b"")], "a.ply");
}

#[test]
fn a_scene_that_does_not_exist() {
    fails(&[], &["compare", "nowhere.glb"], "nowhere.glb");
    fails(&[], &["render", "cities", "-o", "a.png"], "city");
}

#[test]
fn a_medium_that_is_not_one() {
    for (option, value, cause) in [
        ("--sigma-s", "-1", "negative"),
        ("--sigma-s", "0.1,-0.1,0.1", "negative"),
        ("--sigma-a", "nan", "finite"),
        ("--sigma-a", "1e60", "finite"),
        ("--g", "1", "between -1 and 1"),
        ("--medium-box", "0,0,0,1,1,-1", "corner"),
    ] {
        fails(&[], &["compare", "fence", option, value], cause);
        fails(
            &[],
            &["render", "fence", "-o", "a.png", option, value],
            cause,
        );
    }
    let both = ["compare", "fence", "--phase", "rayleigh", "--g", "0.5"];
    fails(&[], &both, "--phase hg");
}

#[test]
fn a_picture_without_pixels_or_with_too_many() {
    for size in ["0x0", "0x10", "10x0", "20000x1", "-3x4", "big"] {
        fails(&[], &["compare", "--size", size], "--size");
        fails(
            &[],
            &["render", "city", "-o", "a.png", "--size", size],
            "--size",
        );
    }
    let huge = ["render", "fence", "-o", "a.exr", "--size", "16384x16384"];
    fails(&[], &huge, "pixels");
    for plan in [&[][..], &["--plan"]] {
        let huge = ["compare", "fence", "--size", "16384x16384"];
        fails(&[], &[&huge[..], plan].concat(), "pixels");
    }
}

#[test]
fn places_that_cannot_be_written() {
    let file: &[(&str, &[u8])] = &[("taken", b"x")];
    fails(
        file,
        &["compare", "fence", "--out", "taken"],
        "not a folder",
    );
    fails(
        file,
        &["compare", "fence", "--out", "taken/deeper"],
        "taken/deeper",
    );
    fails(
        &[],
        &["compare", "fence", "--out", "no/such/place"],
        "no/such/place",
    );
    fails(
        &[],
        &["render", "fence", "-o", "no/such/a.png"],
        "no/such/a.png",
    );
    fails(&[], &["render", "fence", "-o", "a.jpeg"], ".png or .exr");
    fails(&[], &["render", "fence", "-o", "a"], ".png or .exr");
}

#[test]
fn a_folder_with_other_things_in_it() {
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir(place.path().join("work")).unwrap();
    std::fs::write(place.path().join("work/thesis.tex"), "dear").unwrap();
    let output = run(
        place.path(),
        &["compare", "fence", "--quick", "--out", "work"],
    );
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("not an earlier report"), "{message}");
    let kept = std::fs::read(place.path().join("work/thesis.tex")).unwrap();
    assert_eq!(kept, b"dear");
}

#[test]
fn names_and_numbers_that_mean_nothing() {
    fails(
        &[],
        &["compare", "--methods", "photon-mapping"],
        "photon-mapping",
    );
    fails(&[], &["compare", "--studies", "voxles"], "voxels");
    fails(&[], &["compare", "--backend", "abacus"], "abacus");
    fails(&[], &["compare", "--time-budget", "-5"], "--time-budget");
    fails(&[], &["compare", "--tolerance", "0"], "--tolerance");
    fails(&[], &["compare", "--map", "0"], "--map");
    fails(
        &[],
        &["render", "city", "-o", "a.png", "--visibility", "psychic"],
        "psychic",
    );
    fails(
        &[],
        &["render", "city", "-o", "a.png", "--nodes", "5000"],
        "--nodes",
    );
}

#[test]
fn a_shadow_that_nothing_of_that_name_casts_is_an_error() {
    let files = [("card.ply", PLY_TRIANGLE.as_bytes())];
    let render = ["render", "card.ply", "-o", "out.png", "--no-shadow", "lamp"];
    fails(&files, &render, "--no-shadow lamp");
    let bake = ["bake", "card.ply", "-o", "out.dag", "--no-shadow", "lamp"];
    fails(&files, &bake, "--no-shadow lamp");
}
