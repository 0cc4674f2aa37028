// The pictures of a light when this crate assembles the shader.

struct Map {
    faces: array<light_Face, 6>,
    face_count: u32,
    resolution: u32,
    // Of a march through the map.
    samples: u32,
    equi_angular: u32,
}

@group(1) @binding(0) var<uniform> map: Map;

fn light_map_faces() -> u32 {
    return map.face_count;
}

fn light_map_resolution() -> u32 {
    return map.resolution;
}

fn light_map_face(index: u32) -> light_Face {
    return map.faces[index];
}
