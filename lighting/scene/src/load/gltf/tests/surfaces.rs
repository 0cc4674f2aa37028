use std::io::Cursor;

use glam::{Vec2, Vec3};
use image::{ImageFormat, Rgb, RgbImage};

use super::*;
use crate::Light;

/// 2 × 2 texels: red, white above grey, black.
fn image(format: ImageFormat) -> Vec<u8> {
    let mut image = RgbImage::new(2, 2);
    image.put_pixel(0, 0, Rgb([255, 0, 0]));
    image.put_pixel(1, 0, Rgb([255; 3]));
    image.put_pixel(0, 1, Rgb([128; 3]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

const TEXTURED: &str = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"baseColorFactor":[1,0.5,1,1]}}],"textures":[{"source":0}]"#;

#[test]
fn textures_are_decoded_to_linear_rgb_wherever_they_are_kept() {
    let png = image(ImageFormat::Png);
    let escaped: String = png.iter().map(|byte| format!("%{byte:02x}")).collect();
    for images in [
        r#"{"bufferView":3,"mimeType":"image/png"}"#.to_owned(),
        format!(r#"{{"uri":"data:image/png,{escaped}"}}"#),
        r#"{"uri":"somewhere.png"}"#.to_owned(),
    ] {
        let (mut draft, mesh) = square();
        draft.view(&png, "");
        let file = draft.glb(&format!(r#"{mesh},{TEXTURED},"images":[{images}]"#));
        let loaded = gltf_from_slice(&file, &mut |path| {
            assert_eq!(path, "somewhere.png");
            Ok(png.clone())
        })
        .unwrap();
        let material = &loaded.scene.materials[0];
        assert_eq!(material.base_color, Vec3::new(1.0, 0.5, 1.0));
        let texels = material.base_color_texture.as_ref().unwrap().texels();
        assert_eq!(texels[..2], [Vec3::X, Vec3::ONE]);
        // IEC 61966-2-1: 128/255 is 0.2158605.
        assert!((texels[2] - 0.215_860_5).abs().max_element() < 1e-6);
        assert_eq!(texels[3], Vec3::ZERO);
        let coordinates = &loaded.scene.meshes[0].texture_coordinates;
        assert_eq!(coordinates[..2], [Vec2::Y, Vec2::ONE]);
    }
}

#[test]
fn sixteen_bit_and_jpeg_images_are_read() {
    let mut png = Cursor::new(Vec::new());
    let grey = image::ImageBuffer::from_pixel(3, 1, image::Luma([32768_u16]));
    image::DynamicImage::ImageLuma16(grey)
        .write_to(&mut png, ImageFormat::Png)
        .unwrap();
    for (bytes, mean) in [
        (png.into_inner(), 0.214_051),
        (image(ImageFormat::Jpeg), 0.35),
    ] {
        let (mut draft, mesh) = square();
        draft.view(&bytes, "");
        let loaded = draft
            .load(&format!(
                r#"{mesh},{TEXTURED},"images":[{{"bufferView":3,"mimeType":"image/png"}}]"#
            ))
            .unwrap();
        let texture = loaded.scene.materials[0]
            .base_color_texture
            .as_ref()
            .unwrap();
        let tolerance = if mean == 0.35 { 0.3 } else { 1e-4 };
        assert!(
            (texture.mean().x - mean).abs() < tolerance,
            "{}",
            texture.mean()
        );
    }
}

#[test]
fn a_texture_that_cannot_be_read_is_left_out_with_a_note() {
    let mut huge = image(ImageFormat::Png);
    // The width in the header, and its checksum.
    huge[16..20].copy_from_slice(&70_000_u32.to_be_bytes());
    let bad = [
        (vec![0; 40], "neither PNG nor JPEG"),
        (image(ImageFormat::Png)[..60].to_vec(), "image 0"),
        (huge, "image 0"),
        (Vec::new(), "neither PNG nor JPEG"),
    ];
    for (bytes, cause) in bad {
        let (mut draft, mesh) = square();
        draft.view(&bytes, "");
        let loaded = draft
            .load(&format!(
                r#"{mesh},{TEXTURED},"images":[{{"bufferView":3}}],"scenes":[{{"nodes":[0]}}]"#
            ))
            .unwrap();
        assert_eq!(loaded.scene.materials[0].base_color_texture, None);
        assert!(loaded.notes[0].contains(cause), "{:?}", loaded.notes);
    }
    let (draft, mesh) = square();
    for images in [
        r#"{"uri":"gone.png"}"#,
        r#"{"uri":"ftp://a/b.png"}"#,
        "{}",
        "",
    ] {
        let file = draft.glb(&format!(r#"{mesh},{TEXTURED},"images":[{images}]"#));
        let loaded = gltf_from_slice(&file, &mut |path| {
            Err(LoadError::Unsupported(path.to_owned()))
        })
        .unwrap();
        assert_eq!(loaded.scene.materials[0].base_color_texture, None);
        assert!(loaded.notes[1].contains("left out"), "{:?}", loaded.notes);
    }
}

#[test]
fn texture_coordinates_come_from_the_set_and_type_that_the_file_names() {
    let corners: [(u8, u8); 4] = [(0, 255), (255, 255), (255, 0), (51, 0)];
    let bytes: Vec<u8> = corners.iter().flat_map(|&(u, v)| [u, v, 7, 7]).collect();
    let shorts: Vec<u8> = corners.iter().flat_map(|&(u, v)| [u, u, v, v]).collect();
    for (component, data) in [(5121, bytes), (5123, shorts)] {
        let (mut draft, mesh) = square();
        let view = draft.view(&data, r#","byteStride":4"#);
        draft.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"normalized":true,"type":"VEC2","count":4}}"#
        ));
        draft.view(&image(ImageFormat::Png), "");
        let accessor = draft.accessors.len() - 1;
        let mesh = mesh.replace(
            "\"TEXCOORD_0\"",
            &format!("\"TEXCOORD_3\":{accessor},\"TEXCOORD_0\""),
        );
        let material = TEXTURED.replace("\"index\":0", "\"index\":0,\"texCoord\":3");
        let loaded = draft
            .load(&format!(
                r#"{mesh},{material},"images":[{{"bufferView":4}}]"#
            ))
            .unwrap();
        let coordinates = &loaded.scene.meshes[0].texture_coordinates;
        assert_eq!(coordinates[0], Vec2::Y);
        assert!((coordinates[3] - Vec2::new(0.2, 0.0)).length() < 1e-6);
    }
}

#[test]
fn an_emissive_rectangle_is_an_area_light_on_its_front() {
    let (draft, mesh) = square();
    let mesh = mesh.replace(
        r#""nodes":[{"mesh":0}]"#,
        r#""nodes":[{"mesh":0,"translation":[0,0,4],"scale":[1,0.5,1]},{"mesh":0,"scale":[1,1,-1]}]"#,
    );
    let loaded = draft
        .load(&format!(
            r#"{mesh},"materials":[{{"emissiveFactor":[1,0.5,0],"extensions":{{"KHR_materials_emissive_strength":{{"emissiveStrength":6}}}}}}],"extensionsRequired":["KHR_materials_emissive_strength"],"scenes":[{{"nodes":[0,1]}}]"#
        ))
        .unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.materials[0].emitted, Vec3::new(6.0, 3.0, 0.0));
    assert_eq!(scene.instances.len(), 2, "the glowing mesh stays");
    assert_eq!(scene.lights.len(), 2);
    for (light, normal) in scene.lights.iter().zip([Vec3::Z * 2.0, Vec3::NEG_Z * 4.0]) {
        let Light::Area(light) = light else {
            panic!("{light:?}");
        };
        assert_eq!(light.edges[0].cross(light.edges[1]), normal);
        assert_eq!(light.radiance, Vec3::new(6.0, 3.0, 0.0));
        assert_eq!(light.texture, None);
    }
    assert_eq!(loaded.notes, Vec::<String>::new());
}

#[test]
fn an_emissive_texture_stays_upright_on_its_area_light() {
    let (mut draft, mesh) = square();
    draft.view(&image(ImageFormat::Png), "");
    let rest = format!(
        r#"{mesh},"materials":[{{"emissiveFactor":[2,2,2],"emissiveTexture":{{"index":0}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":3}}]"#
    );
    let loaded = draft.load(&rest).unwrap();
    let Light::Area(light) = &loaded.scene.lights[0] else {
        panic!("{:?}", loaded.scene.lights);
    };
    let at = |place: Vec3| {
        let [u, v] = light.edges;
        let local = place - light.corner;
        let uv = Vec2::new(local.dot(u) / u.dot(u), local.dot(v) / v.dot(v));
        light.texture.as_ref().unwrap().clamp(uv)
    };
    assert_eq!(light.edges[0].cross(light.edges[1]), Vec3::Z * 4.0);
    assert_eq!(at(Vec3::new(-0.5, 0.5, 0.0)), Vec3::X, "red above left");
    assert_eq!(at(Vec3::new(0.5, 0.5, 0.0)), Vec3::ONE, "white above right");
    assert_eq!(
        at(Vec3::new(0.5, -0.5, 0.0)),
        Vec3::ZERO,
        "black below right"
    );
    let mean = light.texture.as_ref().unwrap().mean();
    assert!((loaded.scene.materials[0].emitted - 2.0 * mean).length() < 1e-6);

    let tiled = rest.replace(r#""TEXCOORD_0":1"#, r#""TEXCOORD_1":1"#);
    let loaded = draft.load(&tiled).unwrap();
    let Light::Area(light) = &loaded.scene.lights[0] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert!(light.texture.is_none() && (light.radiance - 2.0 * mean).length() < 1e-6);
    assert!(
        loaded
            .notes
            .iter()
            .any(|n| n.contains("mean of its texture"))
    );
}

#[test]
fn other_glowing_shapes_light_nothing_and_say_so() {
    let (draft, mesh) = tetrahedron();
    let mesh = mesh.replace("\"indices\"", "\"material\":0,\"indices\"");
    let loaded = draft
        .load(&format!(
            r#"{mesh},"materials":[{{"emissiveFactor":[1,1,1],"alphaMode":"BLEND"}}],"nodes":[{{"mesh":0}}]"#
        ))
        .unwrap();
    assert!(loaded.scene.lights.is_empty());
    let notes = loaded.notes.join("\n");
    assert!(notes.contains("glows but"), "{notes}");
}
