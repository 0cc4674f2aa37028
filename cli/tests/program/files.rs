//! Options of how a file is read.

use crate::common::{fails, notes, succeeds};

/// A card in the plane z = 0, 1 x 2 in the unit of the file, whose third axis is up.
const CARD: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n100 0 0\n100 0 200\n0 0 200\n4 0 1 2 3\n";

#[test]
fn a_file_may_be_in_centimetres_with_z_up() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("card.ply"), CARD).unwrap();
    // Where the same card is in metres with +Y up.
    let metres = CARD
        .replace("100 0 200", "1 2 0")
        .replace("0 0 200", "0 2 0");
    let metres = metres.replace("100 0 0", "1 0 0");
    std::fs::write(place.path().join("metres.ply"), metres).unwrap();
    let render = |scene: &str, more: &[&str]| {
        let options = ["render", scene, "--size", "16x16", "-o", "a.exr"];
        succeeds(place.path(), &[&options[..], more].concat());
        std::fs::read(place.path().join("a.exr")).unwrap()
    };
    let right = render("metres.ply", &[]);
    assert!(render("card.ply", &["--unit", "cm", "--up", "z"]) == right);
    assert!(render("card.ply", &["--unit", "0.01", "--up", "z"]) == right);
    assert!(render("card.ply", &["--up", "z"]) != right);

    let card = |more: &[&'static str]| [&["render", "card.ply", "-o", "a.png"], more].concat();
    fails(place.path(), &card(&["--unit", "yard"]), "--unit");
    fails(place.path(), &card(&["--unit", "-1"]), "--unit");
    fails(place.path(), &card(&["--up", "w"]), "--up");
    fails(
        place.path(),
        &["render", "city", "--up", "z", "-o", "a.png"],
        "city is an embedded scene",
    );
}

/// A triangle whose buffer is `uri`.
fn gltf(uri: &str, more: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36, "uri": "{uri}"}}]{more}}}"#
    )
}

fn triangle() -> Vec<u8> {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    corners
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect()
}

#[test]
fn files_outside_of_its_folder_need_a_word() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    std::fs::create_dir_all(at("scenes")).unwrap();
    std::fs::create_dir_all(at("library/deep")).unwrap();
    std::fs::write(at("library/deep/a.bin"), triangle()).unwrap();
    std::fs::write(at("a.bin"), triangle()).unwrap();
    std::fs::write(at("scenes/in.gltf"), gltf("../library/deep/a.bin", "")).unwrap();
    std::fs::write(at("scenes/out.gltf"), gltf("../a.bin", "")).unwrap();
    let render = |scene: &'static str, more: &[&'static str]| {
        [&["render", scene, "--size", "8x8", "-o", "a.png"], more].concat()
    };
    let assets = ["--assets", "library"];
    fails(
        place.path(),
        &render("scenes/in.gltf", &[]),
        "folder for assets",
    );
    succeeds(place.path(), &render("scenes/in.gltf", &assets));
    fails(
        place.path(),
        &render("scenes/out.gltf", &assets),
        "folder for assets",
    );
    fails(
        place.path(),
        &render("scenes/in.gltf", &["--unit", "cm"]),
        "glTF is in metres",
    );
}

#[test]
fn what_may_carry_geometry_is_left_out_only_if_asked() {
    let place = tempfile::tempdir().unwrap();
    let file = gltf("a.bin", r#", "extensionsRequired": ["X_holograms"]"#);
    std::fs::write(place.path().join("a.gltf"), file).unwrap();
    std::fs::write(place.path().join("a.bin"), triangle()).unwrap();
    let render = ["render", "a.gltf", "--size", "8x8", "-o", "a.png"];
    fails(place.path(), &render, "X_holograms");
    let lenient = [&render[..], &["--lenient"]].concat();
    let notes = notes(place.path(), &lenient);
    assert!(notes.contains("geometry may be missing"), "{notes}");
    // A bake reads the same file.
    let bake = ["bake", "a.gltf", "--resolution", "64", "-o", "a.cpvs"];
    fails(place.path(), &bake, "X_holograms");
    succeeds(place.path(), &[&bake[..], &["--lenient"]].concat());
}
