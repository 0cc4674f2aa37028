// Directions as points of a square: the shader's side of octahedron.rs.
//
// Needs the part face.wgsl.

// Kinds of pictures; they take the place of the number of faces.
const light_HEMISPHERE: u32 = 0x100u;
const light_SPHERE: u32 = 0x101u;

// 1 with the sign of x.
fn light_sign(x: f32) -> f32 {
    return select(1.0, -1.0, x < 0.0);
}

// Column and row, from 0 to the resolution, at which a picture of this kind shows what lies
// along `v` from the light; the first is negative where the picture does not show it.
fn light_octahedral(face: light_Face, kind: u32, resolution: u32, v: vec3<f32>) -> vec2<f32> {
    let local = vec3(dot(v, face.right), dot(v, face.up), dot(v, face.forward));
    let sum = abs(local.x) + abs(local.y) + abs(local.z);
    if !(sum > 0.0) || (kind == light_HEMISPHERE && local.z <= 0.0) {
        return vec2(-1.0);
    }
    let p = local.xy / sum;
    var at = p;
    if kind == light_HEMISPHERE {
        at = vec2(p.x + p.y, p.x - p.y);
    } else if local.z < 0.0 {
        at = (1.0 - abs(p.yx)) * vec2(light_sign(p.x), light_sign(p.y));
    }
    let n = f32(resolution);
    return clamp(0.5 * n * (1.0 + at), vec2(0.0), vec2(n));
}

// How many times as wide texels are along `v` as on the axes of the frame.
fn light_width(face: light_Face, v: vec3<f32>) -> f32 {
    let sum = abs(dot(v, face.right)) + abs(dot(v, face.up)) + abs(dot(v, face.forward));
    let ratio = sum / length(v);
    return ratio * sqrt(ratio);
}
