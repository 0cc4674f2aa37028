// Where a point is in the pictures of a light.

// The pictures of a light: one, or six in the order of light_cube_face; none if the light has
// no casters.
struct light_Pictures {
    faces: array<light_Face, 6>,
    face_count: u32,
    resolution: u32,
    padding_a: u32,
    padding_b: u32,
}

// Which of six faces a direction points at, in the order +X −X +Y −Y +Z −Z.
fn light_cube_face(v: vec3<f32>) -> u32 {
    let a = abs(v);
    if a.x >= a.y && a.x >= a.z {
        return select(0u, 1u, v.x < 0.0);
    }
    if a.y >= a.z {
        return select(2u, 3u, v.y < 0.0);
    }
    return select(4u, 5u, v.z < 0.0);
}

// Which of a light's faces shows what lies along v from the light.
fn light_face_along(face_count: u32, v: vec3<f32>) -> u32 {
    if face_count > 1u {
        return light_cube_face(v);
    }
    return 0u;
}

// Column and row at which a face shows its origin plus `v`, from 0 to the
// resolution; the first is negative outside of the picture.
fn light_texel_along(face: light_Face, resolution: u32, v: vec3<f32>) -> vec2<f32> {
    var plane = vec2(dot(v, face.right), dot(v, face.up));
    if face.tan > 0.0 {
        let z = dot(v, face.forward);
        if z <= 0.0 {
            return vec2(-1.0);
        }
        plane *= 1.0 / (z * face.tan);
    } else {
        plane /= vec2(face.half_width, face.half_height);
    }
    let n = f32(resolution);
    let texel = 0.5 * n * vec2(1.0 + plane.x, 1.0 - plane.y);
    if !(texel.x >= 0.0 && texel.x <= n && texel.y >= 0.0 && texel.y <= n) {
        return vec2(-1.0);
    }
    return texel;
}

// The depth of the origin of a face plus `v`, m: the distance from a light at a point, the
// depth along the direction of parallel light.
fn light_depth_of(face: light_Face, v: vec3<f32>) -> f32 {
    return select(dot(v, face.forward), length(v), face.tan > 0.0);
}
