// Gives to light_plain_airlight the parts of a ray along which the light shines alike in all
// directions from within the medium and does not fade: all of them, those in the full cone
// of a spotlight, or none. The quadrature does the rest.
//
// Needs the part quadrature.wgsl and
//   fn light_plain_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32>

fn light_airlight_by_cone(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let emitter = light_emitter();
    let is_spot = emitter.emission == light_SPOT && emitter.cookie_width == 0u;
    let is_plain = emitter.emission == light_ISOTROPIC;
    if emitter.fades != 0u || !light_is_immersed() || !(is_plain || is_spot) {
        return light_quadrature_airlight(path, start, end);
    }
    if is_plain {
        return light_plain_airlight(path, start, end);
    }
    var total = vec3(0.0);
    var from_here = start;
    for (var i = 0u; i <= light_KINKS && from_here < end; i++) {
        var to = end;
        if i < light_KINKS {
            to = min(path.kinks[min(i, light_KINKS - 1u)], end);
        }
        if from_here < to {
            if light_is_full(path, emitter, from_here) && light_is_full(path, emitter, to) {
                total += light_plain_airlight(path, from_here, to);
            } else {
                total += light_smooth_quadrature(path, from_here, to);
            }
            from_here = to;
        }
    }
    return total;
}

// From this share of its full brightness on a spotlight counts as full, see `LightPath`.
const light_FULL: f32 = 0.999996;

// Whether a position lies in the cone in which a spotlight is full.
fn light_is_full(path: light_Path, emitter: light_Emitter, x: f32) -> bool {
    var direction = path.direction;
    if x < light_FAR {
        direction = light_from_light(path, x - path.foot).xyz;
    }
    let off_axis = emitter.axis - direction;
    return emitter.outer_versine - 0.5 * dot(off_axis, off_axis) >= light_FULL * emitter.edge;
}
