use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;

use super::*;

fn load_nodes(nodes: &str) -> Loaded {
    let (draft, mesh) = tetrahedron();
    draft.load(&format!("{mesh},{nodes}")).unwrap()
}

fn centre(scene: &Scene) -> Vec3 {
    let geometry = Geometry::new(scene).unwrap();
    let corners = geometry.triangles().as_flattened();
    corners.iter().sum::<Vec3>() / corners.len() as f32
}

#[test]
fn transforms_are_applied_parents_last() {
    let half = FRAC_1_SQRT_2;
    let loaded = load_nodes(&format!(
        r#""nodes":[{{"children":[1],"translation":[10,0,0],"rotation":[0,0,{half},{half}]}},{{"mesh":0,"scale":[2,2,2],"translation":[0,1,0]}}],"scenes":[{{"nodes":[0],"name":"turned"}}],"scene":0"#
    ));
    // A quarter turn about z takes (0.5, 1.5, 0.5) to (-1.5, 0.5, 0.5).
    assert!((centre(&loaded.scene) - Vec3::new(8.5, 0.5, 0.5)).length() < 1e-5);
    assert!((volume(&loaded.scene) - 8.0 / 6.0).abs() < 1e-5);
    assert_eq!(loaded.scene.name, "turned");
    assert_eq!(loaded.notes, Vec::<String>::new());
}

#[test]
fn a_matrix_is_read_by_columns() {
    let loaded = load_nodes(
        r#""nodes":[{"mesh":0,"matrix":[0,3,0,0,-1,0,0,0,0,0,1,0,7,8,9,1]}],"scenes":[{"nodes":[0]}]"#,
    );
    assert!((centre(&loaded.scene) - Vec3::new(6.75, 8.75, 9.25)).length() < 1e-5);
}

#[test]
fn mirrored_nodes_keep_their_triangles_facing_outwards() {
    let loaded = load_nodes(
        r#""nodes":[{"mesh":0,"scale":[-1,1,1]},{"mesh":0,"translation":[5,0,0]},{"mesh":0,"scale":[-1,-2,1]},{"children":[4],"scale":[1,1,-1]},{"mesh":0,"scale":[1,-1,1]}]"#,
    );
    assert!((volume(&loaded.scene) - 5.0 / 6.0).abs() < 1e-5);
    assert_eq!(loaded.scene.instances.len(), 4);
    assert_eq!(loaded.scene.meshes.len(), 2, "one for each handedness");
    assert_eq!(loaded.notes.len(), 1, "the document has no scene");
}

#[test]
fn lists_strips_and_fans_with_any_indices_draw_the_same_square() {
    let corner = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let order = |order: &[usize]| order.iter().map(|&i| corner[i]).collect::<Vec<_>>();
    let list = [0, 1, 2, 2, 3, 0];
    let (strip, fan) = ([0, 1, 3, 2], [0, 1, 2, 3]);
    for (mode, order_of_mode) in [(4, &list[..]), (5, &strip), (6, &fan)] {
        for index_type in [0, 5121, 5123, 5125] {
            let mut draft = Draft::default();
            let bytes: Vec<u8> = match index_type {
                5121 => order_of_mode.iter().map(|&i| i as u8).collect(),
                5123 => order_of_mode
                    .iter()
                    .flat_map(|&i| (i as u16).to_le_bytes())
                    .collect(),
                _ => order_of_mode
                    .iter()
                    .flat_map(|&i| (i as u32).to_le_bytes())
                    .collect(),
            };
            let mut rest = format!(r#""meshes":[{{"primitives":[{{"mode":{mode},"#);
            if index_type == 0 {
                let positions = draft.positions(&order(order_of_mode));
                rest += &format!(r#""attributes":{{"POSITION":{positions}}}"#);
            } else {
                let positions = draft.positions(&corner);
                let indices = draft.accessor(&bytes, index_type, "SCALAR", order_of_mode.len());
                rest += &format!(r#""attributes":{{"POSITION":{positions}}},"indices":{indices}"#);
            }
            let loaded = draft
                .load(&(rest + r#"}]}],"nodes":[{"mesh":0}]"#))
                .unwrap();
            let geometry = Geometry::new(&loaded.scene).unwrap();
            assert_eq!(geometry.triangles().len(), 2);
            let area: Vec3 = geometry
                .triangles()
                .iter()
                .map(|[a, b, c]| 0.5 * (b - a).cross(c - a))
                .sum();
            assert_eq!(area, Vec3::Z, "mode {mode}, index type {index_type}");
        }
    }
}

#[test]
fn the_corners_of_odd_strip_triangles_are_turned() {
    let mut draft = Draft::default();
    let zigzag: Vec<[f32; 3]> = (0..9_u8)
        .map(|i| [f32::from(i), f32::from(i % 2), 0.0])
        .collect();
    let positions = draft.positions(&zigzag);
    let loaded = draft
        .load(&format!(
            r#""meshes":[{{"primitives":[{{"mode":5,"attributes":{{"POSITION":{positions}}}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
        .unwrap();
    let geometry = Geometry::new(&loaded.scene).unwrap();
    assert_eq!(geometry.triangles().len(), 7);
    for [a, b, c] in geometry.triangles() {
        assert!((b - a).cross(c - a).z < 0.0);
    }
}

#[test]
fn interleaved_arrays_are_read_with_their_stride() {
    let mut draft = Draft::default();
    let mut bytes = vec![9; 4];
    for position in TETRAHEDRON {
        bytes.extend(bytemuck::bytes_of(&position));
        bytes.extend([255; 8]);
    }
    bytes.truncate(bytes.len() - 8);
    let view = draft.view(&bytes, r#","byteStride":20"#);
    draft.accessors.push(format!(
        r#"{{"bufferView":{view},"byteOffset":4,"componentType":5126,"type":"VEC3","count":4}}"#
    ));
    let indices = draft.indices(&FACES);
    let loaded = draft
        .load(&format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":{indices}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
        .unwrap();
    assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 1e-6);
}

#[test]
fn several_meshes_and_primitives_are_kept_apart_and_lines_are_noted() {
    let mut draft = Draft::default();
    let (positions, indices) = (draft.positions(&TETRAHEDRON), draft.indices(&FACES));
    let primitive = format!(r#""attributes":{{"POSITION":{positions}}},"indices":{indices}"#);
    let loaded = draft
        .load(&format!(
            r#""meshes":[{{"name":"two","primitives":[{{{primitive}}},{{{primitive},"mode":1}},{{{primitive},"material":0}},{{"attributes":{{"NORMAL":0}}}}]}},{{"name":"one","primitives":[{{{primitive}}}]}},{{"primitives":[{{"attributes":{{"POSITION":77}}}}]}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.25,0.5,1,0.5]}}}}],"nodes":[{{"mesh":0}},{{"mesh":1}},{{"mesh":0}}],"animations":[{{"channels":[],"samplers":[]}}]"#
        ))
        .unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.meshes.len(), 3, "what nothing uses is not read");
    let uses: Vec<usize> = scene.instances.iter().map(|i| i.mesh).collect();
    assert_eq!(uses, [0, 1, 2, 0, 1]);
    let white = scene.meshes[0].material.unwrap();
    assert_eq!(scene.materials[white].base_color, Vec3::ONE);
    let material = &scene.materials[scene.meshes[1].material.unwrap()];
    assert_eq!(material.base_color, Vec3::new(0.25, 0.5, 1.0));
    assert_eq!(scene.meshes[1].name, "two");
    let notes = loaded.notes.join("\n");
    for part in ["Lines", "no positions", "animations", "no scene"] {
        assert!(notes.contains(part), "{notes}");
    }
}

#[test]
fn the_default_scene_is_read_and_the_first_is_the_default_default() {
    let nodes = r#""nodes":[{"mesh":0},{"mesh":0,"translation":[50,0,0]}],"scenes":[{"nodes":[0]},{"nodes":[1]}]"#;
    let first = load_nodes(nodes);
    assert!(centre(&first.scene).x < 1.0);
    assert!(
        first.notes[0].contains("first is used"),
        "{:?}",
        first.notes
    );
    let second = load_nodes(&format!(r#"{nodes},"scene":1"#));
    assert!(centre(&second.scene).x > 49.0);
}

#[test]
fn buffers_come_from_files_and_data_uris() {
    let (draft, mesh) = tetrahedron();
    let rest = format!(r#"{mesh},"nodes":[{{"mesh":0}}]"#);
    let json = draft.json(Some("a%20b/c.bin"), &rest);
    let loaded = gltf_from_slice(json.as_bytes(), &mut |path| {
        assert_eq!(path, "a b/c.bin");
        Ok(draft.binary.clone())
    });
    assert!((volume(&loaded.unwrap().scene) - 1.0 / 6.0).abs() < 1e-6);

    let escaped: String = draft
        .binary
        .iter()
        .map(|byte| format!("%{byte:02x}"))
        .collect();
    let json = draft.json(
        Some(&format!("data:application/octet-stream,{escaped}")),
        &rest,
    );
    let with_mark = [b"\xef\xbb\xbf", json.as_bytes()].concat();
    assert!((volume(&load(&with_mark).unwrap().scene) - 1.0 / 6.0).abs() < 1e-6);
}
