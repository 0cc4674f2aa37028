//! The tetrahedron as Draco's own encoder compresses it.

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::load::damage;

/// EdgeBreaker, standard traversal: colours 0, texture coordinates 1, positions 2
/// (14 bits).
const STANDARD: &[u8] = include_bytes!("../../testdata/standard.drc");

/// EdgeBreaker, valence traversal: the same.
const VALENCE: &[u8] = include_bytes!("../../testdata/valence.drc");

/// Corner by corner, positions 0 alone.
const SEQUENTIAL: &[u8] = include_bytes!("../../testdata/sequential.drc");

/// A document with the tetrahedron, there compressed alone.
fn compressed(stream: &[u8], attributes: &str) -> Vec<u8> {
    let (draft, rest) = document(stream, attributes);
    draft.glb(&rest)
}

fn document(stream: &[u8], attributes: &str) -> (Draft, String) {
    let mut draft = Draft::default();
    let view = draft.view(stream, "");
    for (component, shape, count) in [
        (5126, "VEC3", 4),
        (5123, "SCALAR", 12),
        (5126, "VEC2", 4),
        (5121, "VEC3", 4),
    ] {
        draft.accessors.push(format!(
            r#"{{"componentType":{component},"type":"{shape}","count":{count}}}"#
        ));
    }
    let more = match attributes.contains("TEXCOORD") {
        true => r#","TEXCOORD_0":2,"COLOR_0":3"#,
        false => "",
    };
    let rest = format!(
        r#""extensionsRequired":["KHR_draco_mesh_compression"],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{more}}},"indices":1,"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":{view},"attributes":{{{attributes}}}}}}}}}]}}],"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]"#
    );
    (draft, rest)
}

const ALL: &str = r#""POSITION":2,"TEXCOORD_0":1,"COLOR_0":0"#;

#[test]
fn meshes_come_out_as_they_went_in() {
    for stream in [STANDARD, VALENCE] {
        let loaded = load(&compressed(stream, ALL)).unwrap();
        assert_eq!(loaded.notes, Vec::<String>::new());
        // A step of 14 bits is 6e-5.
        assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 2e-4);
        let mesh = &loaded.scene.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 4));
        for (position, color) in mesh.positions.iter().zip(&mesh.colors) {
            let expected = match position.round() {
                Vec3::ZERO => Vec4::new(1.0, 0.0, 0.0, 1.0),
                Vec3::X => Vec4::new(0.0, 1.0, 0.0, 1.0),
                Vec3::Y => Vec4::new(0.0, 0.0, 1.0, 1.0),
                _ => Vec4::ONE,
            };
            assert_eq!(*color, expected, "{position}");
        }
    }
    let loaded = load(&compressed(SEQUENTIAL, r#""POSITION":0"#)).unwrap();
    assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 2e-4);
}

#[test]
fn textures_lie_where_they_lay() {
    let (draft, rest) = document(STANDARD, ALL);
    let rest = rest.replace("\"indices\":1", "\"indices\":1,\"material\":0");
    let more = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"a.png"}]"#;
    let json = draft.json(Some("a.bin"), &format!("{rest},{more}"));
    let mut picture = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(1, 1)
        .write_to(&mut picture, image::ImageFormat::Png)
        .unwrap();
    let loaded = gltf_from_slice(json.as_bytes(), &mut |path| match path {
        "a.bin" => Ok(draft.binary.clone()),
        _ => Ok(picture.get_ref().clone()),
    });
    let mesh = &loaded.unwrap().scene.meshes[0];
    for (position, uv) in mesh.positions.iter().zip(&mesh.texture_coordinates) {
        let expected = match position.round() {
            Vec3::ZERO => Vec2::ZERO,
            Vec3::X => Vec2::X,
            Vec3::Y => Vec2::Y,
            _ => Vec2::ONE,
        };
        assert!((*uv - expected).length() < 1e-3, "{position} {uv}");
    }
}

#[test]
fn what_does_not_fit_is_refused_or_left_out() {
    for (attributes, cause) in [
        (
            r#""POSITION":7"#,
            "POSITION in the compressed data of mesh 0",
        ),
        (r#""POSITION":1"#, "as many components"),
        (r#""POSITION":0"#, "component type"),
        (r#""POSITION":"secret""#, "a whole number"),
    ] {
        let file = compressed(STANDARD, attributes);
        let error = load(&file).unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("secret"),
            "{error}"
        );
    }
    let file = compressed(b"DRACO\x02\x02 and no more", ALL);
    let error = load(&file).unwrap_err().to_string();
    assert!(error.contains("the compressed data of mesh 0"), "{error}");
    let error = load_leniently(&file).unwrap_err().to_string();
    assert!(error.contains("no triangles"), "{error}");
}

#[test]
fn a_mesh_that_is_there_uncompressed_too_is_not_decompressed() {
    let (draft, mesh) = tetrahedron();
    let mesh = mesh.replace(
        "\"indices\"",
        r#""extensions":{"KHR_draco_mesh_compression":{"bufferView":99}},"indices""#,
    );
    let loaded = draft
        .load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#))
        .unwrap();
    assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 1e-6);
}

#[test]
fn damage_never_panics() {
    for stream in [STANDARD, VALENCE, SEQUENTIAL] {
        damage::survives(stream, |damaged| drop(load(&compressed(damaged, ALL))));
    }
}
