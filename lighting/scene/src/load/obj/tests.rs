//! OBJ files written here, good and bad.

use std::io::Cursor;

use super::*;
use crate::{Geometry, Light};

fn read_with(text: &str, files: &[(&str, &[u8])]) -> Result<Loaded, LoadError> {
    let open = &mut |path: &str| {
        let found = files.iter().find(|(name, _)| *name == path);
        let found = found.map(|(_, bytes)| bytes.to_vec());
        found.ok_or_else(|| LoadError::Unsupported("a file that is not there".into()))
    };
    obj_from_slice(text.as_bytes(), &LoadOptions::default(), open)
}

fn read(text: &str) -> Result<Loaded, LoadError> {
    read_with(text, &[])
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

#[test]
fn faces_count_forwards_and_backwards_in_any_line_ends() {
    for text in [
        format!("{CORNERS}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
        format!("{CORNERS}f -4 -2 -3\nf 1//7 2//7 4//7\nf 1 4 \\\n3\nf 2 3 4"),
        format!("# caf\u{e9}\n{CORNERS}vn 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
            .replace('\n', "\r\n"),
        format!("{CORNERS}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").replace('\n', "\r"),
    ] {
        let loaded = read(&text).unwrap();
        let geometry = Geometry::new(&loaded.scene).unwrap();
        let triangles = geometry.triangles().iter();
        let volume: f32 = triangles.map(|[a, b, c]| a.dot(b.cross(*c))).sum();
        assert!((volume - 1.0).abs() < 1e-6, "{text}");
        assert_eq!(loaded.notes, Vec::<String>::new());
    }
}

#[test]
fn materials_colours_and_coordinates_come_along() {
    let mut png = Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, 51]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let library = "newmtl red paint\nKd 1 0.5 0\nKe 0 0 3\nTr 0.25\nNs oops\n\
                   newmtl leaf\nmap_Kd -s 1 1 1 leaf.png\nmap_d -s 1 1 1 leaf.png\n\
                   newmtl plain\nKd 1 one 1\n";
    let text = format!(
        "mtllib a.mtl\nmtllib a.mtl\n{CORNERS}vt 0 0\nvt 1 0.25\no thing\nusemtl red paint\n\
         f 1 2 3\nusemtl leaf\nf 1/1 2/2 4/2\nusemtl nothing\nf 1 3 4\n"
    );
    let png = png.into_inner();
    let loaded = read_with(&text, &[("a.mtl", library.as_bytes()), ("leaf.png", &png)]).unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.meshes.len(), 3);
    let of = |mesh: usize| scene.meshes[mesh].material.map(|m| &scene.materials[m]);
    let red = of(0).unwrap();
    assert_eq!((red.name.as_str(), red.opacity), ("red paint", 0.75));
    assert_eq!(red.base_color, Vec3::new(1.0, 0.5, 0.0));
    assert_eq!((red.emitted, red.alpha), (Vec3::Z * 3.0, AlphaMode::Blend));
    let leaf = of(1).unwrap();
    assert_eq!(leaf.alpha, AlphaMode::Blend);
    let texture = leaf.base_color_texture.as_ref().unwrap();
    assert_eq!(texture.alpha(), Some(&[0.2][..]));
    assert_eq!(texture.texels(), [Vec3::X]);
    let uv = &scene.meshes[1].texture_coordinates;
    assert_eq!(
        uv[..],
        [
            Vec2::new(0.0, 1.0),
            Vec2::new(1.0, 0.75),
            Vec2::new(1.0, 0.75)
        ]
    );
    assert_eq!(of(2), None);
    assert!(
        scene
            .lights
            .iter()
            .all(|light| matches!(light, Light::Area(_)))
    );
    assert_eq!(scene.meshes[0].name, "thing");
}

#[test]
fn vertex_colours_are_kept_if_all_vertices_have_them() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 3 2 1\n";
    let colors = read(text).unwrap().scene.meshes[0].colors.clone();
    assert_eq!(colors[0], Vec4::new(0.0, 0.0, 1.0, 1.0));
    let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 4 0 2\nf 3 2 1\n";
    let mesh = &read(text).unwrap().scene.meshes[0];
    assert_eq!((mesh.colors.len(), mesh.positions[0]), (0, Vec3::Y * 2.0));
}

#[test]
fn concave_faces_are_covered_once_and_far_ones_are_moved() {
    let outline = [[0, 0], [0, 3], [1, 3], [1, 1], [3, 1], [3, 0]];
    for start in 0..6 {
        let mut text = String::new();
        for i in 0..6 {
            let [x, z]: [i32; 2] = outline[(start + i) % 6];
            text += &format!("v {}.125 0 {}.375\n", 500_000 + x, 4_600_000 + z);
        }
        let loaded = read(&(text + "f 1 2 3 4 5 6\n")).unwrap();
        let geometry = Geometry::new(&loaded.scene).unwrap();
        let area = |[a, b, c]: &[Vec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
        let area: f32 = geometry.triangles().iter().map(area).sum();
        assert!((area - 5.0).abs() < 1e-4, "{area}");
        assert!(loaded.offset.x > 499_999.0 && loaded.offset.z > 4_599_999.0);
        assert!(loaded.notes[0].contains("moved by"), "{:?}", loaded.notes);
    }
}

#[test]
fn missing_materials_are_a_note() {
    let text = format!("mtllib gone.mtl\n{CORNERS}usemtl a\nf 1 2 3\nl 1 2\np 1\n");
    let notes = read(&text).unwrap().notes.join("\n");
    assert!(notes.contains("materials left out"), "{notes}");
    assert!(notes.contains("2 points, lines"), "{notes}");
}

#[test]
fn bad_files_are_refused_without_repeating_them() {
    for (text, cause) in [
        ("", "no triangles"),
        ("root:x:0:0:secret\n", "no triangles"),
        ("v 1 2\n", "line 1"),
        ("v 1 2 secret\n", "line 1"),
        ("v 0 0 0\nf 1 2 secret\n", "line 2"),
        ("v 0 0 0\nf 1 2 0\n", "other than 0"),
        ("v 0 0 0\nf 1 2 -2\n", "before a face"),
        ("v 0 0 0\nf 1 2 3\n", "vertices for all"),
        ("v 0 0 0\nf 1 2 99999999999\n", "2^32"),
        ("v 0 0 0\nf /1 1 1\n", "a vertex at each corner"),
        ("v 0 0 0\nvt 0 0\nf 1/4 1/1 1/1\n", "texture coordinates"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(cause), "{text}: {error}");
        assert!(!error.contains("secret"), "{error}");
    }
}

#[test]
fn damage_never_panics() {
    let library = "newmtl a\nKd 1 0.5 0\nKe 0 0 3\nd 0.25\nmap_Kd x.png\n";
    let text = format!(
        "mtllib a.mtl\n{CORNERS}vt 0 0\nvt 1 0.25\ng a\nusemtl a\nf 1/1 2/2 3/1 4/-1\n\
         f -1/-1 -2/-2 -3/-1\no b\nusemtl none\nf 1 3 4\n"
    );
    crate::load::damage::survives(text.as_bytes(), |damaged| {
        let open = &mut |_: &str| Ok(library.as_bytes().to_vec());
        let _ = obj_from_slice(damaged, &LoadOptions::default(), open);
    });
    crate::load::damage::survives(library.as_bytes(), |damaged| {
        let open = &mut |_: &str| Ok(damaged.to_vec());
        let _ = obj_from_slice(text.as_bytes(), &LoadOptions::default(), open);
    });
}
