use glam::{Vec2, Vec3};
use image::{Rgba, RgbaImage};

use super::*;
use crate::{AlphaMode, Caster, Filter, Light, Material, Sampler, Wrap};

/// 2 × 1 texels: opaque red, clear green.
fn png() -> Vec<u8> {
    let mut image = RgbaImage::new(2, 1);
    image.put_pixel(0, 0, Rgba([255, 0, 0, 255]));
    image.put_pixel(1, 0, Rgba([0, 255, 0, 0]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The square with this material, texture 0 of that image and this sampler.
fn with_material(material: &str, texture: &str) -> Result<Loaded, LoadError> {
    let (mut draft, mesh) = square();
    let view = draft.view(&png(), "");
    draft.load(&format!(
        r#"{mesh},"materials":[{material}],"textures":[{{"source":0{texture}}}],"samplers":[{{"wrapS":33071,"wrapT":33648,"magFilter":9728}}],"images":[{{"bufferView":{view}}}],"scenes":[{{"nodes":[0]}}]"#
    ))
}

fn material(json: &str) -> Material {
    with_material(json, "").unwrap().scene.materials[0].clone()
}

#[test]
fn without_a_material_a_surface_is_white() {
    let (draft, mesh) = tetrahedron();
    let loaded = draft
        .load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#))
        .unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    let appearance = geometry.appearance(&loaded.scene, 0, 0.2, 0.2);
    assert_eq!(appearance.albedo, Vec3::ONE);
    assert_eq!(material("{}").base_color, Vec3::ONE);
}

#[test]
fn alpha_modes_are_kept_with_their_factor_and_cutoff() {
    let blend = material(
        r#"{"name":"pane","alphaMode":"BLEND","doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}}"#,
    );
    assert_eq!((blend.alpha, blend.opacity), (AlphaMode::Blend, 0.25));
    assert_eq!((blend.name.as_str(), blend.double_sided), ("pane", true));
    let mask = material(r#"{"alphaMode":"MASK"}"#);
    assert_eq!(mask.alpha, AlphaMode::Mask { cutoff: 0.5 });
    let mask = material(r#"{"alphaMode":"MASK","alphaCutoff":0.7}"#);
    assert_eq!(mask.alpha, AlphaMode::Mask { cutoff: 0.7 });
    assert_eq!(material("{}").alpha, AlphaMode::Opaque);
    for (json, cause) in [
        (r#"{"alphaMode":"secret"}"#, "alphaMode"),
        (r#"{"alphaMode":"MASK","alphaCutoff":-1}"#, "alphaCutoff"),
        (
            r#"{"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,2]}}"#,
            "alpha of baseColorFactor",
        ),
    ] {
        let error = with_material(json, "").unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("secret"),
            "{error}"
        );
    }
}

#[test]
fn half_of_a_masked_card_casts_a_shadow() {
    let json = r#"{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#;
    let loaded = with_material(json, r#","sampler":0"#).unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    // The triangles of the square are 0, 1, 2 and 2, 3, 0.
    for (triangle, u, v, passes) in [
        (0, 0.1, 0.1, 0.0),
        (0, 0.6, 0.2, 1.0),
        (1, 0.6, 0.3, 0.0),
        (1, 0.05, 0.05, 1.0),
    ] {
        let caster = geometry.caster(triangle);
        assert!(matches!(caster, Caster::Masked(_)));
        assert_eq!(caster.transmittance(u, v), Vec3::splat(passes));
    }
    let texture = loaded.scene.materials[0]
        .base_color_texture
        .clone()
        .unwrap();
    assert_eq!(texture.alpha(), Some(&[1.0, 0.0][..]));
    let sampler = Sampler {
        wrap: [Wrap::Clamp, Wrap::Mirror],
        filter: Filter::Nearest,
    };
    assert_eq!(texture.sampler(), sampler);
}

#[test]
fn a_window_of_opacity_zero_lets_all_light_through() {
    let json = r#"{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0]}}"#;
    let loaded = with_material(json, "").unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    let Caster::SeeThrough(coating) = geometry.caster(0) else {
        panic!("{:?}", geometry.caster(0));
    };
    assert_eq!(coating.constant(), Some(Vec3::ONE));
    assert_eq!(
        geometry.appearance(&loaded.scene, 0, 0.3, 0.3).albedo,
        Vec3::ZERO
    );
}

#[test]
fn transmission_is_coloured_by_the_base_colour() {
    let json = r#"{"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5}},"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}"#;
    let loaded = with_material(json, "").unwrap();
    assert_eq!(loaded.scene.materials[0].transmission, 0.5);
    let geometry = Geometry::new(&loaded.scene).unwrap();
    let passing = geometry.caster(0).transmittance(0.1, 0.1);
    assert!((passing - Vec3::new(0.5, 0.25, 0.0)).length() < 1e-6);
    for (factor, cause) in [("2", "is 2"), ("\"secret\"", "a text"), ("null", "null")] {
        let json = format!(
            r#"{{"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":{factor}}}}}}}"#
        );
        let error = with_material(&json, "").unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
}

#[test]
fn a_transmission_texture_multiplies_the_factor_with_its_own_coordinates() {
    // Red is 1 on the left and 0 on the right of the image, which is turned around.
    let json = r#"{"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5,"transmissionTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[1,0],"scale":[-1,1]}}}}},"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#;
    let loaded = with_material(json, r#","sampler":0"#).unwrap();
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
    let material = &loaded.scene.materials[0];
    let texture = material.transmission_texture.as_ref().unwrap();
    let sampler = Sampler {
        wrap: [Wrap::Clamp, Wrap::Mirror],
        filter: Filter::Nearest,
    };
    assert_eq!(texture.sampler(), sampler);
    let geometry = Geometry::new(&loaded.scene).unwrap();
    // The first triangle is 0, 1, 2: u of the image is u + v.
    for (at, passes, albedo) in [
        // Nothing passes where the base colour is red, half of the light where it
        // is green.
        (0.2, Vec3::ZERO, Vec3::X),
        (0.8, Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.0)),
    ] {
        let found = geometry.caster(0).transmittance(0.5 * at, 0.5 * at);
        assert!((found - passes).length() < 1e-6, "{at}: {found}");
        let appearance = geometry.appearance(&loaded.scene, 0, 0.5 * at, 0.5 * at);
        assert!(
            (appearance.albedo - albedo).length() < 1e-6,
            "{appearance:?}"
        );
    }
    for (bad, cause) in [
        (r#"{"texCoord":0}"#, "nameless"),
        (r#"{"index":-1}"#, "damaged"),
        (r#"{"index":7}"#, "7"),
        (r#"{"index":0,"texCoord":"a"}"#, "damaged"),
    ] {
        let json = format!(
            r#"{{"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1,"transmissionTexture":{bad}}}}}}}"#
        );
        let error = with_material(&json, "").unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
}

/// Shares are stored as they are, not as sRGB has colours.
#[test]
fn transmission_textures_are_linear() {
    let mut image = RgbaImage::new(1, 1);
    image.put_pixel(0, 0, Rgba([51, 0, 0, 255]));
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let (mut draft, mesh) = square();
    let view = draft.view(&png.into_inner(), "");
    let loaded = draft.load(&format!(
        r#"{mesh},"materials":[{{"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1,"transmissionTexture":{{"index":0}}}}}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":{view}}}],"scenes":[{{"nodes":[0]}}]"#
    ));
    let geometry = Geometry::new(&loaded.unwrap().scene).unwrap();
    let passing = geometry.caster(0).transmittance(0.3, 0.3);
    assert!((passing - Vec3::splat(0.2)).length() < 1e-6, "{passing}");
}

#[test]
fn texture_transforms_move_the_coordinates() {
    // The lower left quadrant, turned clockwise by a right angle: the example
    // of the specification.
    let transform =
        r#"{"offset":[0,1],"rotation":1.5707963267948966,"scale":[0.5,0.5],"texCoord":0}"#;
    let json = format!(
        r#"{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"texCoord":5,"extensions":{{"KHR_texture_transform":{transform}}}}}}}}}"#
    );
    let loaded = with_material(&json, "").unwrap();
    let coordinates = &loaded.scene.meshes[0].texture_coordinates;
    // (0, 1), (1, 1), (1, 0) and (0, 0) in the file.
    for (found, expected) in
        coordinates
            .iter()
            .zip([[0.5, 1.0], [0.5, 0.5], [0.0, 0.5], [0.0, 1.0]])
    {
        assert!(
            (*found - Vec2::from_array(expected)).length() < 1e-6,
            "{found}"
        );
    }
    let bad = json.replace("[0.5,0.5]", "[0.5]");
    let error = with_material(&bad, "").unwrap_err().to_string();
    assert!(
        error.contains("KHR_texture_transform of material 0"),
        "{error}"
    );
}

#[test]
fn a_transform_that_turns_an_emissive_texture_is_seen_by_the_light() {
    let flipped = r#"{"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[1,0],"scale":[-1,1]}}}}"#;
    for (json, red_is_left) in [
        (
            r#"{"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}}"#,
            true,
        ),
        (flipped, false),
    ] {
        let loaded = with_material(json, "").unwrap();
        let Light::Area(light) = &loaded.scene.lights[0] else {
            panic!("{:?}", loaded.scene.lights);
        };
        let texture = light.texture.as_ref();
        let Some(texture) = texture else {
            assert!(!red_is_left, "the mean is right for mirrored textures only");
            assert!((light.radiance - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-6);
            continue;
        };
        let place = Vec3::new(-0.5, 0.0, 0.0) - light.corner;
        let [u, v] = light.edges;
        let uv = Vec2::new(place.dot(u) / u.dot(u), place.dot(v) / v.dot(v));
        assert_eq!(texture.clamp(uv).x > 0.5, red_is_left);
    }
}

#[test]
fn a_double_sided_rectangle_lights_both_sides() {
    let json = r#"{"name":"sign","emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},"doubleSided":true}"#;
    let loaded = with_material(json, "").unwrap();
    let [Light::Area(front), Light::Area(back)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    let normal = |light: &crate::AreaLight| light.edges[0].cross(light.edges[1]);
    assert_eq!(normal(front), -normal(back));
    assert_eq!(front.name, "sign");
    for light in [front, back] {
        let place = Vec3::new(-0.5, 0.2, 0.0) - light.corner;
        let [u, v] = light.edges;
        let uv = Vec2::new(place.dot(u) / u.dot(u), place.dot(v) / v.dot(v));
        let seen = light.texture.as_ref().unwrap().clamp(uv);
        assert_eq!(seen, Vec3::X, "red is at the same place of both sides");
    }
}

#[test]
fn vertex_colours_multiply_the_base_colour_in_any_of_their_types() {
    let floats: Vec<u8> = [[1.0, 0.0, 0.5, 0.25_f32]; 4]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let bytes = [255, 0, 128, 64].repeat(4);
    let shorts: Vec<u8> = [65535, 0, 32768, 16384_u16]
        .repeat(4)
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let opaque = [255, 0, 128, 0].repeat(4);
    for (component, shape, data, alpha) in [
        (5126, "VEC4", floats, 0.25),
        (5121, "VEC4", bytes, 0.25),
        (5123, "VEC4", shorts, 0.25),
        (5121, "VEC3", opaque, 1.0),
    ] {
        let (mut draft, mesh) = square();
        let stride = if shape == "VEC3" {
            r#","byteStride":4"#
        } else {
            ""
        };
        let view = draft.view(&data, stride);
        draft.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"normalized":true,"type":"{shape}","count":4}}"#
        ));
        let accessor = draft.accessors.len() - 1;
        let mesh = mesh.replace(
            "\"POSITION\"",
            &format!("\"COLOR_0\":{accessor},\"POSITION\""),
        );
        let loaded = draft
            .load(&format!(
                r#"{mesh},"materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorFactor":[0.5,1,1,1]}}}}]"#
            ))
            .unwrap();
        let color = loaded.scene.meshes[0].colors[2];
        assert!(
            (color - glam::Vec4::new(1.0, 0.0, 0.5, alpha)).length() < 5e-3,
            "{color}"
        );
        let geometry = Geometry::new(&loaded.scene).unwrap();
        let albedo = geometry.appearance(&loaded.scene, 1, 0.3, 0.3).albedo;
        assert!(
            (albedo - alpha * Vec3::new(0.5, 0.0, 0.5)).length() < 5e-3,
            "{albedo}"
        );
    }
}

#[test]
fn textures_in_formats_that_are_not_read_are_notes_even_if_required() {
    for (extension, mime, bytes) in [
        ("EXT_texture_webp", "webp", &b"RIFF\x04\0\0\0WEBPVP8 "[..]),
        ("KHR_texture_basisu", "ktx2", b"\xabKTX 20\xbb\r\n\x1a\n"),
    ] {
        let (mut draft, mesh) = square();
        let view = draft.view(bytes, "");
        let loaded = draft
            .load(&format!(
                r#"{mesh},"extensionsUsed":["{extension}"],"extensionsRequired":["{extension}"],"materials":[{{"alphaMode":"MASK","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"textures":[{{"extensions":{{"{extension}":{{"source":0}}}}}}],"images":[{{"bufferView":{view},"mimeType":"image/{mime}"}}]"#
            ))
            .unwrap();
        assert!(Geometry::new(&loaded.scene).unwrap().all_solid());
        let notes = loaded.notes.join("\n").to_lowercase();
        assert!(
            notes.contains(mime) && notes.contains("opacity of its factor"),
            "{notes}"
        );
    }
    let (draft, mesh) = square();
    let loaded = draft
        .load(&format!(
            r#"{mesh},"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"textures":[{{}}]"#
        ))
        .unwrap();
    assert_eq!(loaded.scene.materials[0].base_color_texture, None);
}
