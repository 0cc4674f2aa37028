// A ray in the pictures of a light: which picture shows a part of it, and where.
//
// Needs the parts face.wgsl and place.wgsl. Positions on a ray are measured from the
// foot point of a light at a point, and from the ray's origin in parallel light.

// Positions from here on are infinite.
const light_line_END: f32 = 1e30;

const light_line_NO_PICTURE: u32 = 6u;

// From the light to the position 0, and the direction.
struct light_line_Ray {
    base: vec3<f32>,
    direction: vec3<f32>,
}

// The picture that shows a ray up to the position `end`; light_line_NO_PICTURE if none does.
struct light_line_Shown {
    face: u32,
    end: f32,
}

// Homogeneous coordinates, in a picture, of the light's origin plus v; of the direction v if
// w is 0. Inside of the picture |x| and |y| are at most w.
fn light_line_picture(face: light_Face, v: vec3<f32>, w: f32) -> vec3<f32> {
    let x = dot(v, face.right);
    let y = -dot(v, face.up);
    if face.tan > 0.0 {
        return vec3(x / face.tan, y / face.tan, dot(v, face.forward));
    }
    return vec3(x / face.half_width, y / face.half_height, w);
}

// A position between two, of which the second may be infinite.
fn light_line_middle(a: f32, b: f32) -> f32 {
    return select(0.5 * (a + b), a + max(abs(a), 1.0), b >= light_line_END);
}

// The next position behind s at which base + s slope is 0, if that is before `next`.
fn light_line_root(base: f32, slope: f32, s: f32, next: f32) -> f32 {
    if slope == 0.0 {
        return next;
    }
    let root = -base / slope;
    return select(next, root, s < root && root < next);
}

// The picture that shows what follows the position s, on a ray that ends at `end`. `first` is
// the first of the light's `face_count` pictures.
fn light_line_enter(
    first: light_Face,
    face_count: u32,
    ray: light_line_Ray,
    s: f32,
    end: f32,
) -> light_line_Shown {
    let v = ray.base;
    let d = ray.direction;
    var b = end;
    let is_cube = face_count > 1u;
    let p = light_line_picture(first, v, 1.0);
    let q = light_line_picture(first, d, 0.0);
    if is_cube {
        for (var i = 0u; i < 3u; i++) {
            let j = (i + 1u) % 3u;
            b = light_line_root(v[i] - v[j], d[i] - d[j], s, b);
            b = light_line_root(v[i] + v[j], d[i] + d[j], s, b);
        }
    } else {
        for (var i = 0u; i < 2u; i++) {
            b = light_line_root(p.z - p[i], q.z - q[i], s, b);
            b = light_line_root(p.z + p[i], q.z + q[i], s, b);
        }
        b = light_line_root(p.z, q.z, s, b);
    }
    let middle = light_line_middle(s, b);
    if is_cube {
        return light_line_Shown(light_cube_face(v + middle * d), b);
    }
    let at = p + middle * q;
    let inside = at.z > 0.0 && abs(at.x) <= at.z && abs(at.y) <= at.z;
    return light_line_Shown(select(light_line_NO_PICTURE, 0u, inside), b);
}
