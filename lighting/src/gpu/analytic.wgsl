// A table of airlight as the evaluator, for lights that shine alike in all
// directions from within the medium and do not fade, and in the full cone of
// spotlights; the quadrature for all others.
//
// Needs the part TABLE of `airlight` too, and the variables
//   light_table: air_Table
//   light_table_cells: array<vec4<u32>>

fn air_table_uniforms() -> air_Table {
    return light_table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return light_table_cells[index];
}

fn light_analytic_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
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

// How far up the rim of a spotlight its light counts as full, see `LightPath`.
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

// The airlight of an interval in which the light shines alike in all directions.
fn light_plain_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let medium = light_medium();
    let segment = light_segment(path, start, end);
    let sigma_t = medium.sigma_t;
    var airlight = vec3(air_table_airlight(sigma_t.x, segment));
    if !all(sigma_t == vec3(sigma_t.x)) {
        airlight.y = air_table_airlight(sigma_t.y, segment);
        airlight.z = air_table_airlight(sigma_t.z, segment);
    }
    // A channel without light stays dark, even through the light.
    let light = medium.sigma_s * light_emitter().intensity;
    return select(vec3(0.0), min(light * airlight, vec3(light_FAR)), light > vec3(0.0));
}
