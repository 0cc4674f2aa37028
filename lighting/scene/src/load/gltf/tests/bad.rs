use super::*;
use crate::load::damage;
use crate::load::gltf::read;
use crate::load::limits::Budget;

/// Loads the tetrahedron after replacing a part of the document.
fn altered(old: &str, new: &str) -> String {
    let (draft, mesh) = tetrahedron();
    let rest = format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#);
    let json = draft.json(Some("x.bin"), &rest);
    assert!(json.contains(old), "{old} is not in {json}");
    let json = json.replacen(old, new, 1);
    match gltf_from_slice(json.as_bytes(), &mut |_| Ok(draft.binary.clone())) {
        Ok(loaded) => format!("loaded with {:?}", loaded.notes),
        Err(error) => error.to_string(),
    }
}

#[test]
fn lies_about_lengths_are_found_before_they_are_believed() {
    for (old, new, cause) in [
        (
            "\"count\":4",
            "\"count\":5",
            "accessor 0 of mesh 0 needs 60 bytes, but there are only 48",
        ),
        ("\"count\":4", "\"count\":4000000000", "48000000000"),
        ("\"count\":4", "\"count\":18446744073709551615", "only 48"),
        ("\"count\":12", "\"count\":13", "accessor 1"),
        (
            "\"componentType\":5123",
            "\"componentType\":5125",
            "48 bytes, but there are only 24",
        ),
        (
            "\"componentType\":5126",
            "\"byteOffset\":1,\"componentType\":5126",
            "49 bytes",
        ),
        (
            "\"componentType\":5126",
            "\"byteOffset\":18446744073709551615,\"componentType\":5126",
            "only 48",
        ),
        ("\"byteLength\":48", "\"byteLength\":73", "buffer view 0"),
        (
            "\"byteLength\":48",
            "\"byteLength\":18446744073709551615",
            "buffer view 0",
        ),
        ("\"byteOffset\":48", "\"byteOffset\":49", "buffer view 1"),
        (
            "\"byteLength\":48",
            "\"byteStride\":8,\"byteLength\":48",
            "stride",
        ),
        (
            "\"byteLength\":48",
            "\"byteStride\":0,\"byteLength\":48",
            "stride",
        ),
        (
            "\"byteLength\":48",
            "\"byteStride\":9999999999999,\"byteLength\":48",
            "only 48",
        ),
        (
            "\"byteLength\":72",
            "\"byteLength\":73",
            "buffer 0 needs 73 bytes, but there are only 72",
        ),
        (
            "\"byteLength\":72",
            "\"byteLength\":18446744073709551615",
            "buffer 0",
        ),
        ("\"count\":12", "\"count\":0", "no triangles"),
        (
            "\"count\":12",
            "\"count\":11",
            "loaded with [\"the document has no scene: all of its nodes are used\", \"mesh 0 has 11",
        ),
        (
            "\"count\":4",
            "\"count\":3",
            "vertex index 3 is out of range, there are 3",
        ),
    ] {
        let outcome = altered(old, new);
        assert!(outcome.contains(cause), "{new}: {outcome}");
    }
}

#[test]
fn bad_documents_are_refused_with_their_cause() {
    for (old, new, cause) in [
        ("\"2.0\"", "\"1.0\"", "version 1.0"),
        ("\"2.0\"", "\"2.1\"", "loaded"),
        ("\"2.0\"", "\"2.1\",\"minVersion\":\"2.1\"", "version 2.1"),
        ("\"buffers\"", "\"buffers\":{},\"b\"", "malformed"),
        ("{", "{{", "malformed"),
        ("\"type\":\"VEC3\"", "\"type\":\"VEC4\"", "VEC3"),
        ("\"type\":\"VEC3\"", "\"type\":\"VEC9\"", "VEC3"),
        ("5126", "5122", "KHR_mesh_quantization"),
        ("5126", "99", "5120 to 5126"),
        ("5123", "5122", "accessor 1 of the indices of mesh 0 is I16"),
        ("\"POSITION\":0", "\"POSITION\":7", "accessor index 7"),
        ("\"indices\":1", "\"indices\":7", "accessor index 7"),
        (
            "\"bufferView\":1",
            "\"bufferView\":7",
            "buffer view index 7",
        ),
        ("\"buffer\":0", "\"buffer\":7", "buffer index 7"),
        ("{\"mesh\":0}", "{\"mesh\":7}", "mesh index 7"),
        (
            "\"indices\":1",
            "\"indices\":1,\"material\":7",
            "material index 7",
        ),
        (
            "\"indices\":1",
            "\"indices\":1,\"mode\":9",
            "mode of mesh 0",
        ),
        ("{\"mesh\":0}", "{\"camera\":7}", "camera index 7"),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"children\":[7]}",
            "node index 7",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"rotation\":[0,0,0,0]}",
            "rotation of node 0",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"scale\":[1e99,1,1]}",
            "finite",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"matrix\":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}",
            "last row",
        ),
        (
            "\"bufferView\":0",
            "\"sparse\":{\"count\":5,\"indices\":{\"bufferView\":0,\"componentType\":5125},\"values\":{\"bufferView\":0}}",
            "a sparse index of accessor 0 of mesh 0 is",
        ),
        ("\"nodes\"", "\"scene\":3,\"nodes\"", "scene index 3"),
        (
            "\"nodes\"",
            "\"scenes\":[{\"nodes\":[3]}],\"nodes\"",
            "node index 3",
        ),
        (
            "\"nodes\"",
            "\"scenes\":[{\"nodes\":[]}],\"nodes\"",
            "no triangles",
        ),
        ("\"nodes\"", "\"materials\":[{}],\"n\"", "no triangles"),
        ("\"uri\":\"x.bin\"", "\"uri\":\"http://a/b\"", "scheme http"),
        (
            "\"uri\":\"x.bin\"",
            "\"name\":\"blob\"",
            "buffer 0 \"blob\" is without a URI",
        ),
        (
            "\"nodes\"",
            "\"extensionsRequired\":[\"KHR_accessor_float64\"],\"nodes\"",
            "KHR_accessor_float64",
        ),
        (
            "\"nodes\"",
            "\"extensionsRequired\":[\"EXT_meshopt_compression\"],\"nodes\"",
            "loaded",
        ),
        (
            "\"nodes\"",
            "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"nodes\"",
            "loaded",
        ),
        (
            "\"nodes\"",
            "\"extensionsUsed\":[\"KHR_materials_sheen\"],\"nodes\"",
            "loaded with [\"the extension KHR_materials_sheen",
        ),
    ] {
        let outcome = altered(old, new);
        assert!(outcome.contains(cause), "{new}: {outcome}");
    }
    let material = |material: &str| {
        let (draft, mesh) = square();
        let error = draft
            .load(&format!(r#"{mesh},"materials":[{material}]"#))
            .unwrap_err();
        error.to_string()
    };
    for (json, cause) in [
        (
            r#"{"pbrMetallicRoughness":{"baseColorFactor":[1,2,1,1]}}"#,
            "baseColorFactor",
        ),
        (r#"{"emissiveFactor":[1,-2,1]}"#, "emissiveFactor"),
        (
            r#"{"emissiveFactor":[1e30,1,1],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":1e30}}}"#,
            "emissiveFactor",
        ),
        (
            r#"{"emissiveTexture":{"index":4},"emissiveFactor":[1,1,1]}"#,
            "texture index 4",
        ),
    ] {
        let error = material(json);
        assert!(error.contains(cause), "{json}: {error}");
    }
}

#[test]
fn cycles_and_second_parents_are_refused() {
    let node = "{\"mesh\":0}";
    for (nodes, cause) in [
        ("{\"children\":[0]}", "without a root"),
        ("{\"children\":[1]},{\"children\":[0]}", "without a root"),
        (
            "{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}",
            "node 1 is reached twice",
        ),
        (
            "{\"children\":[1,1]},{\"mesh\":0}",
            "node 1 is reached twice",
        ),
        (
            "{\"children\":[2]},{\"children\":[2]},{\"mesh\":0}",
            "node 2 is reached twice",
        ),
    ] {
        let outcome = altered(node, nodes);
        assert!(outcome.contains(cause), "{nodes}: {outcome}");
    }
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_walked() {
    let chain: String = (1..100_000)
        .map(|i| format!("{{\"children\":[{i}]}},"))
        .collect();
    let outcome = altered("{\"mesh\":0}", &(chain + "{\"mesh\":0}"));
    assert!(outcome.contains("loaded"), "{outcome}");
}

#[test]
#[cfg(feature = "vol")]
fn smoke_that_is_used_again_and_again_meets_the_limit() {
    // Densities as single bytes, which take four times as much once they are read.
    let mut vol = b"VOL\x03".to_vec();
    for word in [3_u32, 8, 8, 8, 1] {
        vol.extend(word.to_le_bytes());
    }
    for number in [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0] {
        vol.extend(number.to_le_bytes());
    }
    vol.extend([100; 512]);
    let (draft, mesh) = tetrahedron();
    let reads = |smoke: &str, count: usize, limit: u64| {
        let node = format!(r#"{{"extras":{{"smoke":{smoke}}}}}"#);
        let nodes = vec![node; count].join(",");
        let file = draft.glb(&format!(r#"{mesh},"nodes":[{{"mesh":0}},{nodes}]"#));
        let open = &mut |_: &str| Ok(vol.clone());
        read(&file, &LoadOptions::default(), open, Budget::new(limit)).map(drop)
    };
    let least = |smoke: &str, count| {
        let (mut low, mut high) = (0, 100_000);
        while low < high {
            let middle = (low + high) / 2;
            match reads(smoke, count, middle) {
                Ok(()) => high = middle,
                Err(_) => low = middle + 1,
            }
        }
        low
    };
    let (plain, file) = (r#"{"uri":"a.vol"}"#, vol.len() as u64);
    let [one, two] = [1, 2].map(|count| least(plain, count));
    assert_eq!(two - one, file + 512 * 4);
    let error = reads(plain, 2, two - 1).unwrap_err();
    assert!(matches!(error, LoadError::TooLarge { .. }), "{error}");
    assert!(error.to_string().contains("smoke"), "{error}");
    let coloured = r#"{"uri":"a.vol","albedo":{"uri":"a.vol"},"emission":{"uri":"a.vol"}}"#;
    assert_eq!(least(coloured, 1) - one, 2 * (file + 512 * 12));
}

#[test]
fn data_that_is_used_again_and_again_meets_the_limit() {
    let (draft, mesh) = tetrahedron();
    let file = draft.glb(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#));
    let reads = |file: &[u8], limit: u64| {
        let nothing = &mut |_: &str| Ok(Vec::new());
        read(file, &LoadOptions::default(), nothing, Budget::new(limit)).map(drop)
    };
    let least = (0..100_000).find(|limit| reads(&file, *limit).is_ok());
    let least = least.unwrap();
    let primitive = r#"{"attributes":{"POSITION":0},"indices":1}"#;
    let many = mesh.replace(primitive, &[primitive; 10].join(","));
    assert_ne!(many, mesh);
    let file = draft.glb(&format!(r#"{many},"nodes":[{{"mesh":0}}]"#));
    let error = reads(&file, 2 * least).unwrap_err();
    assert!(matches!(error, LoadError::TooLarge { .. }), "{error}");
    let nodes = [r#"{"mesh":0}"#; 10].join(",");
    let file = draft.glb(&format!(r#"{mesh},"nodes":[{nodes}]"#));
    assert!(reads(&file, least).is_err());
}

#[test]
fn a_document_of_too_many_values_is_not_parsed() {
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{}{{}}]}}"#,
        "{},".repeat(3 << 20)
    );
    let error = load(text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("number of values"), "{error}");
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"extras":{}1{}}}"#,
        "[".repeat(5000),
        "]".repeat(5000)
    );
    assert!(matches!(load(text.as_bytes()), Err(LoadError::Json(_))));
}

#[test]
fn every_truncation_of_a_glb_is_an_error() {
    let (draft, mesh) = tetrahedron();
    let file = draft.glb(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#));
    assert!(load(&file).is_ok());
    let sixteenths = (0..16).map(|i| file.len() * i / 16);
    for length in (0..200).chain(sixteenths) {
        assert!(load(&file[..length]).is_err(), "{length}");
    }
    // Also with a header that agrees.
    for length in 12..file.len() - 3 {
        let mut shorter = file[..length].to_vec();
        shorter[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        assert!(load(&shorter).is_err(), "{length}");
    }
}

#[test]
fn bad_glb_headers_are_refused() {
    let (draft, mesh) = tetrahedron();
    let file = draft.glb(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#));
    for (place, value, cause) in [
        (4, 1_u32, "version 1"),
        (8, 11, "at least 12"),
        (8, u32::MAX, "4294967295"),
        (12, u32::MAX, "chunk JSON"),
        (16, 0x004e_4942, "first GLB chunk"),
    ] {
        let mut bad = file.clone();
        bad[place..place + 4].copy_from_slice(&value.to_le_bytes());
        let error = load(&bad).unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
}

#[test]
fn positions_that_are_not_finite_are_left_to_the_geometry() {
    let (mut draft, mesh) = tetrahedron();
    draft.binary[4..8].copy_from_slice(&f32::NAN.to_le_bytes());
    let loaded = draft
        .load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#))
        .unwrap();
    let error = Geometry::new(&loaded.scene).unwrap_err().to_string();
    assert!(error.contains("vertex 0"), "{error}");
}

#[test]
fn damage_never_panics() {
    let (draft, mesh) = square();
    let file = draft.glb(&format!(
        r#"{mesh},"materials":[{{"emissiveFactor":[1,1,1],"emissiveTexture":{{"index":0}}}}],"textures":[{{"source":0}}],"images":[{{"uri":"data:,%00"}}],"scenes":[{{"nodes":[0],"extras":{{"medium":{{"sigma_s":[1,2,3],"phase":"henyey-greenstein","g":0.5,"box":[[0,0,0],[1,1,1]]}}}}}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":0.7,"znear":1}}}}],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","range":5,"spot":{{"innerConeAngle":0.1}}}}]}}}}"#
    ));
    let mut sound = 0;
    damage::survives(&file, |damaged| {
        let missing = &mut |path: &str| Err(LoadError::Unsupported(path.to_owned()));
        if let Ok(loaded) = gltf_from_slice(damaged, missing) {
            sound += 1;
            let _ = Geometry::new(&loaded.scene);
            for light in &loaded.scene.lights {
                let _ = light.emitters(4);
            }
        }
    });
    assert!(sound > 100, "only {sound} copies got past the parser");
}
