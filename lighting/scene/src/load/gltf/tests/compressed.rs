use super::*;

/// A triangle whose indices are compressed: the sequence 0, 1, 2.
fn compressed(extension: &str, more: &str) -> Vec<u8> {
    let mut draft = Draft::default();
    let positions = draft.positions(&TETRAHEDRON);
    // Deltas 0, 1 and 1 to the first baseline.
    let stream = draft.view(&[0xd1, 0, 4, 4, 0, 0, 0, 0], "");
    let start = draft.binary.len() - 8;
    assert_eq!(stream, 1);
    draft.views.push(format!(
        r#"{{"buffer":1,"byteLength":6,"extensions":{{"{extension}":{{"buffer":0,"byteOffset":{start},"byteLength":8,"byteStride":2,"mode":"INDICES","count":3{more}}}}}}}"#
    ));
    draft
        .accessors
        .push(r#"{"bufferView":2,"componentType":5123,"type":"SCALAR","count":3}"#.into());
    let file = draft.json(
        Some("x.bin"),
        &format!(
            r#""extensionsRequired":["{extension}"],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}},"indices":1}}]}}],"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]"#
        ),
    );
    // The buffer that would hold the uncompressed data is not there.
    file.replace(
        r#""uri":"x.bin"}"#,
        &format!(r#""uri":"x.bin"}},{{"byteLength":6,"extensions":{{"{extension}":{{"fallback":true}}}}}}"#),
    )
    .into_bytes()
}

fn load_with_buffer(file: &[u8]) -> Result<Loaded, LoadError> {
    let mut draft = Draft::default();
    draft.positions(&TETRAHEDRON);
    draft.view(&[0xd1, 0, 4, 4, 0, 0, 0, 0], "");
    gltf_from_slice(file, &mut |_| Ok(draft.binary.clone()))
}

#[test]
fn views_are_decompressed_under_either_name_without_their_fallback() {
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let loaded = load_with_buffer(&compressed(extension, "")).unwrap();
        assert_eq!(loaded.scene.meshes[0].triangles, [[0, 1, 2]]);
        assert_eq!(loaded.notes, Vec::<String>::new());
    }
}

#[test]
fn bad_compression_is_refused_with_its_cause() {
    for (old, new, cause) in [
        (
            "\"INDICES\"",
            "\"SECRET\"",
            "mode in the compression of buffer view 2",
        ),
        ("\"count\":3", "\"count\":-3", "count in the compression"),
        ("\"count\":3", "\"count\":4", "buffer view 2"),
        ("\"count\":3", "\"count\":2", "buffer view 2"),
        ("\"byteStride\":2", "\"byteStride\":8", "stride"),
        (
            "\"byteLength\":8,\"byteStride\"",
            "\"byteLength\":7,\"byteStride\"",
            "buffer view 2",
        ),
        (
            "\"byteLength\":8,\"byteStride\"",
            "\"byteLength\":80,\"byteStride\"",
            "buffer view 2",
        ),
        (
            "\"buffer\":0,\"byteOffset\":48,\"byteLength\":8,\"byteStride\"",
            "\"buffer\":9,\"byteOffset\":48,\"byteLength\":8,\"byteStride\"",
            "buffer index 9",
        ),
        (
            "\"buffer\":1,\"byteLength\":6",
            "\"buffer\":1,\"byteLength\":7",
            "needs 7 bytes, but there are only 6",
        ),
    ] {
        let file = String::from_utf8(compressed("EXT_meshopt_compression", "")).unwrap();
        assert!(file.contains(old), "{old} is not in {file}");
        let error = load_with_buffer(file.replacen(old, new, 1).as_bytes());
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("SECRET"),
            "{error}"
        );
    }
    let file = compressed("EXT_meshopt_compression", r#","filter":"SECRET""#);
    let error = load_with_buffer(&file).unwrap_err().to_string();
    assert!(
        error.contains("filter") && !error.contains("SECRET"),
        "{error}"
    );
}

#[test]
fn damage_never_panics() {
    let file = compressed("KHR_meshopt_compression", r#","filter":"NONE""#);
    crate::load::damage::survives(&file, |damaged| drop(load_with_buffer(damaged)));
}
