use glam::Vec3;

use super::*;

/// The tetrahedron with something added to the document and to its primitive.
fn with(document: &str, primitive: &str) -> Vec<u8> {
    let (draft, mesh) = tetrahedron();
    let mesh = mesh.replace("\"indices\"", &format!("{primitive}\"indices\""));
    draft.glb(&format!(
        r#"{mesh},"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]{document}"#
    ))
}

#[test]
fn extensions_that_carry_geometry_are_errors_unless_lenient() {
    for (document, primitive) in [
        (
            r#","extensionsUsed":["X_a"],"extensionsRequired":["X_a"]"#,
            "",
        ),
        (r#","extensionsRequired":["KHR_accessor_float64"]"#, ""),
        (
            r#","extensionsUsed":["X_a"]"#,
            r#""extensions":{"X_a":{}},"#,
        ),
        ("", r#""extensions":{"X_a":{}},"#),
        (r#","extensionsUsed":["KHR_gaussian_splatting"]"#, ""),
    ] {
        let file = with(document, primitive);
        let error = load(&file).unwrap_err().to_string();
        assert!(error.contains("X_a") || error.contains("KHR_"), "{error}");
        let loaded = load_leniently(&file).unwrap();
        let notes = loaded.notes.join("\n");
        assert!(notes.contains("geometry may be missing"), "{notes}");
        assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 1e-6);
    }
}

#[test]
fn extensions_that_carry_none_are_notes() {
    for (document, primitive) in [
        (r#","extensionsRequired":["KHR_materials_clearcoat"]"#, ""),
        (r#","extensionsUsed":["X_unknown"]"#, ""),
        (
            r#","extensionsUsed":["KHR_materials_variants"]"#,
            r#""extensions":{"KHR_materials_variants":{}},"#,
        ),
    ] {
        let loaded = load(&with(document, primitive)).unwrap();
        assert!(loaded.notes[0].contains("is ignored"), "{:?}", loaded.notes);
    }
}

#[test]
fn names_of_extensions_cannot_control_a_terminal() {
    let file = with(r#","extensionsUsed":["X_\u001b[2J"]"#, "");
    let notes = load(&file).unwrap().notes.join("\n");
    assert!(
        notes.contains("X_?[2J") && !notes.contains('\u{1b}'),
        "{notes}"
    );
}

#[test]
fn a_scene_needs_no_nodes() {
    let (draft, mesh) = tetrahedron();
    let loaded = draft.load(&format!(
        r#"{mesh},"nodes":[{{"mesh":0}}],"scene":1,"scenes":[{{}},{{"nodes":[0]}}]"#
    ));
    assert!((volume(&loaded.unwrap().scene) - 1.0 / 6.0).abs() < 1e-6);
    let error = draft
        .load(&format!(
            r#"{mesh},"nodes":[{{"mesh":0}}],"scene":0,"scenes":[{{}}]"#
        ))
        .unwrap_err();
    assert!(error.to_string().contains("no triangles"), "{error}");
}

#[test]
fn gltf_1_is_called_by_its_name() {
    for text in [
        r#"{"asset":{"version":"1.0"},"buffers":{}}"#,
        r#"{"asset":{"version":1.1},"scene":"a"}"#,
        r#"{"scene":"a","nodes":{"a":{}},"scenes":{}}"#,
    ] {
        let error = load(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("glTF 1.0"), "{error}");
    }
    let error = load(b"glTF\x01\0\0\0\x20\0\0\0").unwrap_err().to_string();
    assert!(error.contains("glTF 1.0"), "{error}");
}

#[test]
fn errors_repeat_no_text_of_the_file() {
    for text in [
        r#"{"asset":{"version":"secret"}}"#,
        r#"{"asset":{"version":"2.0"},"scene":"secret"}"#,
        r#"{"asset":{"version":"2.0"},"nodes":["secret"]}"#,
        r#"{"asset":{"version":"2.0"},"nodes":{"secret":1}}"#,
        r#"{"asset":{"version":"2.0"},"cameras":[{"type":"secret \" secret"}],"nodes":[{"name":["secret"]}]}"#,
        "{secret}",
        "{\"a\":secret}",
    ] {
        let error = load(text.as_bytes()).unwrap_err().to_string();
        assert!(!error.contains("secret"), "{error}");
    }
}

#[test]
fn instances_of_a_node_stand_where_their_attributes_put_them() {
    let (mut draft, mesh) = tetrahedron();
    let translations = draft.positions(&[[0.0; 3], [5.0, 0.0, 0.0]]);
    let scales = draft.positions(&[[1.0; 3], [1.0, 2.0, -3.0]]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotations = [[0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half]];
    let rotations = draft.accessor(bytemuck::cast_slice(&rotations), 5126, "VEC4", 2);
    let node = |attributes: &str| {
        draft.load(&format!(
            r#"{mesh},"extensionsRequired":["EXT_mesh_gpu_instancing"],"nodes":[{{"name":"tree","mesh":0,"translation":[0,1,0],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}}}],"scenes":[{{"nodes":[0]}}]"#
        ))
    };
    let loaded = node(&format!(
        r#""TRANSLATION":{translations},"ROTATION":{rotations},"SCALE":{scales},"_ID":0"#
    ))
    .unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.instances.len(), 2);
    assert_eq!(scene.instances[1].name, "tree");
    let at = |point: Vec3| scene.instances[1].transform.transform_point3(point);
    // Scaled, turned from z to x, moved, and moved with the node.
    assert!(
        (at(Vec3::Z) - Vec3::new(2.0, 1.0, 0.0)).length() < 1e-5,
        "{}",
        at(Vec3::Z)
    );
    assert!((at(Vec3::Y) - Vec3::new(5.0, 3.0, 0.0)).length() < 1e-5);
    // Both face outwards, the mirrored one too.
    assert!(
        (volume(scene) - 7.0 / 6.0).abs() < 1e-4,
        "{}",
        volume(scene)
    );
    for (attributes, cause) in [
        ("", "at least one"),
        (r#""TRANSLATION":0,"SCALE":2"#, "one number for all"),
        (r#""TRANSLATION":99"#, "accessor index 99"),
        (r#""TRANSLATION":"secret""#, "the index of an accessor"),
        (r#""ROTATION":2"#, "VEC4"),
    ] {
        let error = node(attributes).unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("secret"),
            "{error}"
        );
    }
}

#[test]
fn what_is_not_visible_is_not_there_nor_are_its_lights() {
    let (draft, mesh) = tetrahedron();
    let hidden = |visible: &str| {
        draft.load(&format!(
            r#"{mesh},"nodes":[{{"mesh":0}},{{"children":[2,3],"extensions":{{"KHR_node_visibility":{{"visible":{visible}}}}}}},{{"mesh":0}},{{"camera":0,"extensions":{{"KHR_lights_punctual":{{"light":0}},"KHR_node_visibility":{{"visible":true}}}}}}],"scenes":[{{"nodes":[0,1]}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":1}}}}],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point"}}]}}}}"#
        ))
    };
    for (visible, instances, lights) in [("true", 2, 1), ("false", 1, 0)] {
        let scene = hidden(visible).unwrap().scene;
        assert_eq!(
            (scene.instances.len(), scene.lights.len()),
            (instances, lights)
        );
        assert!(scene.camera.is_some(), "cameras have no visibility");
    }
    let error = hidden("\"secret\"").unwrap_err().to_string();
    assert!(error.contains("visibility of node 1"), "{error}");
}

#[test]
fn extras_of_nodes_meshes_and_materials_take_shadows_away() {
    let (draft, mesh) = square();
    let no = r#""extras":{"castsShadow":false},"#;
    for (node, on_mesh, material, expected) in [
        ("", "", "", [false, false]),
        (no, "", "", [true, true]),
        ("", no, "", [true, true]),
        ("", "", no, [true, true]),
        (r#""extras":{"castsShadow":1},"#, "", "", [false, false]),
        (r#""extras":{"castsShadow":0},"#, "", "", [true, true]),
    ] {
        let mesh = mesh
            .replace("\"meshes\":[{", &format!("\"meshes\":[{{{on_mesh}"))
            .replace(
                "\"nodes\":[{\"mesh\":0}]",
                &format!("\"nodes\":[{{{node}\"mesh\":0,\"children\":[1]}},{{\"mesh\":0}}]"),
            );
        let rest = format!(r#"{mesh},"materials":[{{{material}"name":"a"}}]"#);
        let scene = draft.load(&rest).unwrap().scene;
        let found: Vec<bool> = scene.instances.iter().map(|i| i.no_shadow).collect();
        assert_eq!(found, expected, "{rest}");
    }
    let mesh = mesh.replace(
        "{\"mesh\":0}",
        r#"{"mesh":0,"extras":{"castsShadow":"secret"}}"#,
    );
    let error = draft
        .load(&format!("{mesh},\"materials\":[{{}}]"))
        .unwrap_err();
    assert!(error.to_string().contains("castsShadow"), "{error}");
    assert!(!error.to_string().contains("secret"), "{error}");
}

#[test]
fn what_moves_is_told_by_nodes_to_all_below_them() {
    let (draft, mesh) = square();
    let mesh = format!(r#"{mesh},"materials":[{{}}]"#);
    for (parent, child, expected) in [
        ("", "", [false, false]),
        ("true", "", [true, true]),
        ("1", "", [true, true]),
        ("", "true", [false, true]),
        ("true", "false", [true, false]),
    ] {
        let [parent, child] = [parent, child].map(|value| match value {
            "" => String::new(),
            value => format!(r#""extras":{{"dynamic":{value}}},"#),
        });
        let nodes = format!(r#""nodes":[{{{parent}"mesh":0,"children":[1]}},{{{child}"mesh":0}}]"#);
        let rest = mesh.replace("\"nodes\":[{\"mesh\":0}]", &nodes);
        let scene = draft.load(&rest).unwrap().scene;
        let found: Vec<bool> = scene.instances.iter().map(|i| i.dynamic).collect();
        assert_eq!(found, expected, "{rest}");
    }
    let rest = mesh.replace("{\"mesh\":0}", r#"{"mesh":0,"extras":{"dynamic":"often"}}"#);
    let error = draft.load(&rest).unwrap_err().to_string();
    assert!(error.contains("dynamic in the extras of node 0"), "{error}");
}
