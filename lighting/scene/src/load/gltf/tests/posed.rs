use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;

use super::*;

/// The tetrahedron with two morph targets: everything 10 up, and the last
/// corner 1 further out (as a sparse accessor without a buffer view).
fn morphing() -> (Draft, String) {
    let (mut draft, mesh) = tetrahedron();
    let up = draft.positions(&[[0.0, 10.0, 0.0]; 4]);
    let place = draft.view(&[3], "");
    let values = draft.view(bytemuck::cast_slice(&[[0.0, 0.0, 1.0_f32]]), "");
    draft.accessors.push(format!(
        r#"{{"componentType":5126,"type":"VEC3","count":4,"sparse":{{"count":1,"indices":{{"bufferView":{place},"componentType":5121}},"values":{{"bufferView":{values}}}}}}}"#
    ));
    let out = draft.accessors.len() - 1;
    let mesh = mesh.replace(
        "\"indices\"",
        &format!(r#""targets":[{{"POSITION":{up}}},{{"POSITION":{out}}}],"indices""#),
    );
    (draft, mesh)
}

fn lowest(scene: &Scene) -> Vec3 {
    let positions = scene.meshes[0].positions.iter().copied();
    positions.reduce(Vec3::min).unwrap()
}

#[test]
fn morph_targets_have_the_weights_of_the_node_or_else_of_the_mesh() {
    let (draft, mesh) = morphing();
    for (on_mesh, on_node, height, size) in [
        ("", "", 0.0, 1.0),
        (r#""weights":[0.5,1],"#, "", 5.0, 2.0),
        (r#""weights":[0.5,1],"#, r#""weights":[0,2],"#, 0.0, 3.0),
        (r#""weights":[1],"#, "", 10.0, 1.0),
    ] {
        let mesh = mesh.replace("\"meshes\":[{", &format!("\"meshes\":[{{{on_mesh}"));
        let loaded = draft
            .load(&format!(r#"{mesh},"nodes":[{{{on_node}"mesh":0}}]"#))
            .unwrap();
        assert!((lowest(&loaded.scene).y - height).abs() < 1e-6);
        assert!((volume(&loaded.scene) - size / 6.0).abs() < 1e-4);
    }
    // Two poses of one mesh are two meshes.
    let loaded = draft
        .load(&format!(
            r#"{mesh},"nodes":[{{"mesh":0,"weights":[0,1]}},{{"mesh":0,"weights":[0,2]}},{{"mesh":0}},{{"mesh":0}}]"#
        ))
        .unwrap();
    assert_eq!(
        (loaded.scene.meshes.len(), loaded.scene.instances.len()),
        (3, 4)
    );
    assert!((volume(&loaded.scene) - 7.0 / 6.0).abs() < 1e-4);
}

#[test]
fn sparse_accessors_replace_elements_of_their_base() {
    let (mut draft, mesh) = tetrahedron();
    let place = draft.view(bytemuck::cast_slice(&[0_u16, 3]), "");
    let values = draft.view(
        bytemuck::cast_slice(&[[0.0, 0.0, -1.0], [0.0, 0.0, 3.0_f32]]),
        "",
    );
    let sparse = |count: u32, first: u32| {
        format!(
            r#""sparse":{{"count":{count},"indices":{{"bufferView":{place},"byteOffset":{first},"componentType":5123}},"values":{{"bufferView":{values}}}}},"bufferView":0"#
        )
    };
    let load = |sparse: &str| {
        let mut draft = Draft {
            binary: draft.binary.clone(),
            views: draft.views.clone(),
            accessors: draft.accessors.clone(),
        };
        draft.accessors[0] = draft.accessors[0].replace("\"bufferView\":0", sparse);
        draft.load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#))
    };
    let loaded = load(&sparse(2, 0)).unwrap();
    let positions = &loaded.scene.meshes[0].positions;
    assert_eq!((positions[0], positions[3]), (Vec3::NEG_Z, Vec3::Z * 3.0));
    assert_eq!(positions[1], Vec3::X);
    for (sparse, cause) in [
        (sparse(3, 0), "sparse indices"),
        (sparse(2, 1), "sparse indices"),
        (sparse(4_000_000_000, 0), "sparse indices"),
        (sparse(1, 0).replace("5123", "5126"), "sparse indices"),
    ] {
        let error = load(&sparse).unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
    let place = draft.view(bytemuck::cast_slice(&[4_u16]), "");
    let beyond = sparse(1, 0).replace(
        "\"bufferView\":2,\"byteOffset\"",
        &format!("\"bufferView\":{place},\"byteOffset\""),
    );
    draft.accessors[0] = draft.accessors[0].replace("\"bufferView\":0", &beyond);
    let error = draft.load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#));
    assert!(error.unwrap_err().to_string().contains("a sparse index"));
}

#[test]
fn elements_in_no_buffer_are_limited() {
    let (mut draft, mesh) = tetrahedron();
    draft.accessors[0] = r#"{"componentType":5126,"type":"VEC3","count":4000000000}"#.into();
    let error = draft
        .load(&format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#))
        .unwrap_err();
    assert!(matches!(error, LoadError::TooLarge { .. }), "{error}");
}

/// A unit square in the plane z = 0 whose two upper corners hang on joint 1.
fn skinned(weights: [[f32; 4]; 4], matrices: bool) -> (Draft, String) {
    let mut draft = Draft::default();
    let positions = draft.positions(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ]);
    let indices = draft.indices(&[0, 1, 2, 0, 2, 3]);
    let joints = [[0_u8, 0, 0, 0], [0; 4], [1, 0, 0, 0], [1, 0, 0, 0]];
    let joints = draft.accessor(bytemuck::cast_slice(&joints), 5121, "VEC4", 4);
    let weights = draft.accessor(bytemuck::cast_slice(&weights), 5126, "VEC4", 4);
    // Joint 0 is bound at the origin, joint 1 at (0, 1, 0).
    let identity = glam::Mat4::IDENTITY.to_cols_array();
    let down = glam::Mat4::from_translation(Vec3::NEG_Y).to_cols_array();
    let bind = draft.accessor(bytemuck::cast_slice(&[identity, down]), 5126, "MAT4", 2);
    let bind = if matrices {
        format!(r#","inverseBindMatrices":{bind}"#)
    } else {
        String::new()
    };
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions},"JOINTS_0":{joints},"WEIGHTS_0":{weights}}},"indices":{indices}}}]}}],"skins":[{{"joints":[1,2]{bind}}}]"#
    );
    (draft, rest)
}

#[test]
fn a_skin_has_the_pose_of_its_joints_wherever_its_node_is() {
    let one = [1.0, 0.0, 0.0, 0.0];
    let (draft, rest) = skinned([one; 4], true);
    // Joint 1 is above joint 0, moved and turned about x: +y becomes +z.
    let nodes = format!(
        r#""nodes":[{{"mesh":0,"skin":0,"translation":[100,100,100]}},{{"children":[2],"translation":[0,0,5]}},{{"translation":[0,2,0],"rotation":[{FRAC_1_SQRT_2},0,0,{FRAC_1_SQRT_2}]}}],"scenes":[{{"nodes":[0,1]}}]"#
    );
    let loaded = draft.load(&format!("{rest},{nodes}")).unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    let [a, b, c] = geometry.triangles()[0];
    assert!((a - Vec3::new(0.0, 0.0, 5.0)).length() < 1e-5, "{a}");
    assert!((b - Vec3::new(1.0, 0.0, 5.0)).length() < 1e-5, "{b}");
    assert!((c - Vec3::new(1.0, 2.0, 5.0)).length() < 1e-5, "{c}");
    // Two halves of both joints, and weights that do not quite sum to 1.
    let half = [0.25, 0.25, 0.0, 0.0];
    let (draft, rest) = skinned([one, one, half, half], true);
    let loaded = draft.load(&format!("{rest},{nodes}")).unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    let [_, _, c] = geometry.triangles()[0];
    // Half of (1, 1, 5) and half of (1, 2, 5).
    assert!((c - Vec3::new(1.0, 1.5, 5.0)).length() < 1e-5, "{c}");
}

#[test]
fn a_scene_far_away_is_moved_to_the_origin_with_its_camera_and_lights() {
    let (draft, rest) = skinned([[1.0, 0.0, 0.0, 0.0]; 4], true);
    // Half a metre is less than a step of f32 there.
    let nodes = r#""nodes":[{"translation":[4649776.125,0.5,500000.2],"children":[1,2,3,4,5]},{"mesh":0,"translation":[0.1,0,0]},{"mesh":0,"translation":[0.2,0,0]},{"camera":0,"translation":[0,0,3]},{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[0,7,0]},{"mesh":0,"skin":0,"children":[6]},{"translation":[1,0,0]}],"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":1}}],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}},"scenes":[{"nodes":[0],"extras":{"medium":{"sigma_s":1,"box":[[4649770,0,500000],[4649780,8,500008]]}}}]"#;
    let rest = rest.replace("\"joints\":[1,2]", "\"joints\":[5,6]");
    let loaded = draft.load(&format!("{rest},{nodes}")).unwrap();
    assert_eq!(loaded.offset, glam::DVec3::new(4_649_776.0, 1.0, 500_000.0));
    assert!(loaded.notes[0].contains("moved by"), "{:?}", loaded.notes);
    let instances = &loaded.scene.instances;
    let [a, b] = [0, 1].map(|i| instances[i].transform.translation);
    assert!((b - a - glam::Vec3A::X * 0.1).length() < 1e-6, "{a} {b}");
    let base = Vec3::new(0.125, -0.5, 0.2);
    let camera = loaded.scene.camera.unwrap();
    assert!((camera.eye() - base - 3.0 * Vec3::Z).length() < 1e-6);
    let crate::Light::Point(light) = &loaded.scene.lights[0] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert!((light.position - base - 7.0 * Vec3::Y).length() < 1e-6);
    let air = loaded.scene.medium.unwrap().bounds().unwrap();
    assert_eq!(air.min(), Vec3::new(-6.0, -1.0, 0.0));
    let skinned = &loaded.scene.meshes[instances[2].mesh];
    assert!((skinned.positions[0] - base).length() < 1e-6);
}

#[test]
fn what_no_joint_holds_stays_and_bad_skins_are_refused() {
    let nodes = r#""nodes":[{"mesh":0,"skin":0},{"children":[2]},{}]"#;
    let (draft, rest) = skinned([[0.0; 4]; 4], false);
    let loaded = draft.load(&format!("{rest},{nodes}")).unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    assert_eq!(geometry.triangles()[0][2], Vec3::new(1.0, 1.0, 0.0));
    let (draft, rest) = skinned([[1.0, 0.0, 0.0, 0.0]; 4], true);
    for (old, new, cause) in [
        (
            "\"joints\":[1,2]",
            "\"joints\":[1]",
            "a joint of mesh 0 is 1",
        ),
        ("\"joints\":[1,2]", "\"joints\":[1,9]", "node index 9"),
        (
            "\"joints\":[1,2]",
            "\"joints\":[1,2,1]",
            "inverse bind matrices",
        ),
        (
            "\"inverseBindMatrices\":4",
            "\"inverseBindMatrices\":0",
            "VEC3",
        ),
        ("\"skin\":0", "\"skin\":3", "skin index 3"),
        ("\"WEIGHTS_0\":3", "\"WEIGHTS_0\":0", "VEC3"),
        (
            "{\"children\":[2]},{}",
            "{\"children\":[2]},{\"children\":[1]}",
            "without a place",
        ),
    ] {
        let text = format!("{rest},{nodes},\"scenes\":[{{\"nodes\":[0]}}]");
        assert!(text.contains(old), "{old} is not in {text}");
        let error = draft
            .load(&text.replacen(old, new, 1))
            .unwrap_err()
            .to_string();
        assert!(error.contains(cause), "{new}: {error}");
    }
}

#[test]
fn quantised_positions_are_normalised_or_not_as_they_say() {
    for (component, normalized, scale, data) in [
        (5122, true, 1.0, shorts(32767)),
        (5122, false, 7.0, shorts(7)),
        (5123, true, 1.0, shorts(-1)),
        (5120, true, 1.0, bytes(127)),
        (5121, false, 9.0, bytes(9)),
    ] {
        let mut draft = Draft::default();
        let view = draft.view(&data, r#","byteStride":8"#);
        draft.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"normalized":{normalized},"type":"VEC3","count":4}}"#
        ));
        let indices = draft.indices(&FACES);
        let loaded = draft
            .load(&format!(
                r#""extensionsRequired":["KHR_mesh_quantization"],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":{indices}}}]}}],"nodes":[{{"mesh":0}}]"#
            ))
            .unwrap();
        let expected = scale * scale * scale / 6.0;
        let found = volume(&loaded.scene);
        assert!(
            (found / expected - 1.0).abs() < 1e-5,
            "{component}: {found}"
        );
    }
}

/// The corners of the tetrahedron times `one`, 8 bytes each.
fn shorts(one: i16) -> Vec<u8> {
    let corner = |p: &[f32; 3]| [p[0] as i16 * one, p[1] as i16 * one, p[2] as i16 * one, 5];
    TETRAHEDRON
        .iter()
        .flat_map(corner)
        .flat_map(i16::to_le_bytes)
        .collect()
}

fn bytes(one: u8) -> Vec<u8> {
    let corner = |p: &[f32; 3]| {
        let [x, y, z] = p.map(|x| x as u8 * one);
        [x, y, z, 1, 2, 3, 4, 5]
    };
    TETRAHEDRON.iter().flat_map(corner).collect()
}

#[test]
fn damage_never_panics() {
    let (draft, rest) = skinned([[0.5, 0.5, 0.0, 0.0]; 4], true);
    let skin = draft.glb(&format!(
        r#"{rest},"nodes":[{{"mesh":0,"skin":0}},{{"children":[2]}},{{"translation":[0,2,0]}}]"#
    ));
    let (draft, mesh) = morphing();
    let mesh = mesh.replace("\"meshes\":[{", "\"meshes\":[{\"weights\":[0.5,1],");
    let morph = draft.glb(&format!(
        r#"{mesh},"nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":0}}}}}}}}]"#
    ));
    for file in [skin, morph] {
        crate::load::damage::survives(&file, |damaged| {
            let missing = &mut |_: &str| Ok(Vec::new());
            let _ = gltf_from_slice(damaged, missing);
        });
    }
}
