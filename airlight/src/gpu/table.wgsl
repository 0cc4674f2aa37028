// Airlight from two lookups, or where these would lose digits, by quadrature:
// the shader's side of `Table`.
//
// Needs
//   fn air_table_uniforms() -> air_Table
//   fn air_table_cell(index: u32) -> vec4<u32>

struct air_Table {
    // How rows lie in front of the foot point (xy) and behind it (zw); see
    // air_table_row.
    slope: vec4<f32>,
    // The units in which the coefficients of second order are packed.
    units: vec3<f32>,
    // Where cells begin to widen along v.
    offset: f32,
    // log2 of the cells per doubling, and the cells along v.
    steps: u32,
    radial: u32,
    // Rows in front of the foot point, and all of them.
    rows_front: u32,
    rows: u32,
    // Nodes for short parts. In the words they come behind the cells and the rows of the
    // phase function; a constant phase function has no rows.
    nodes: u32,
    is_constant: u32,
    // log2 of a constant phase function.
    constant: f32,
    // Nodes for near parts, behind those for short ones.
    near_nodes: u32,
}

// Largest share of the light behind the start of a part that may be left behind its end:
// where more is left, the difference of two lookups loses digits.
const air_TABLE_REST: f32 = 0.5;

// A part is near if its length over the distance of its start from the light is below the
// first of these and twice its optical depth over ln 2 is below the second. It is not
// looked up: most of the light is behind its end.
const air_TABLE_NEAR: f32 = 0.125;
const air_TABLE_THIN: f32 = 0.5;

// Smaller than every length of a scaled segment but 0. It stands for 0 in divisors.
const air_TABLE_LEAST: f32 = 0x1p-110;

// Airlight per unit of σ_s I, in 1/(m sr): 0 for an empty segment, air_FAR for one that
// meets the light.
fn air_table_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    let part = air_scaled(sigma_t, segment);
    if part.kind != air_ORDINARY {
        return select(0.0, air_FAR, part.kind == air_MEETS_LIGHT);
    }
    let octaves = air_LOG2_E * part.sigma;
    let far = part.length >= air_TABLE_NEAR * part.d_start || 2.0 * octaves * part.length >= air_TABLE_THIN;
    if !far {
        return air_table_near(part);
    }
    let start = air_table_end(part, part.s, part.d_start);
    let end = air_table_end(part, part.end, part.d_end);
    // Summed in this order nothing cancels badly: the difference of the distances is at
    // most the length.
    let growth = max(octaves * (part.length + (part.d_end - part.d_start)), 0.0);
    let fall = 2.0 * (end.y - start.y) - growth;
    // The share of the light behind the start that is left behind the end. It is at most 1
    // but for rounding, because what a lookup leaves out never falls along the ray.
    let rest = start.x / end.x * air_exp2(fall);
    if rest < air_TABLE_REST {
        return air_exp2_times((1.0 - rest) / start.x, 2.0 * start.y - part.octaves, -part.exponent);
    }
    return air_table_short(part);
}

// The lookup for one end of a part: `w (1 + v)`, which is the inverse of the factor that
// was left out of the table, and the value of the table, half of a logarithm to base 2.
fn air_table_end(part: air_Scaled, s: f32, d: f32) -> vec2<f32> {
    let table = air_table_uniforms();
    let behind = s >= 0.0;
    let q = abs(s) + d;
    let longer = max(select(part.h, q, behind), air_TABLE_LEAST);
    let v = min(part.sigma * longer, 0x1p+40);
    let row = air_table_row(part.h, q, behind);
    // The axis along v ends at 256. Its cells are parts of octaves: the column is the upper
    // bits of the float, the position in the cell the bits below.
    let bits = bitcast<u32>(min(v, 255.99974 - table.offset) + table.offset);
    let column = (bits - bitcast<u32>(table.offset)) >> (23u - table.steps);
    let fraction = bitcast<f32>(((bits << table.steps) & 0x7fffffu) | 0x3f800000u);
    let index = min(u32(row.x) * table.radial + column, table.radial * table.rows - 1u);
    let value = air_table_polynomial(air_table_cell(index), fraction - 1.5, row.y);
    return vec2(longer * (1.0 + v), value);
}

// The row of `b = h / q`, and the position in it from −1/2 to 1/2.
fn air_table_row(h: f32, q: f32, behind: bool) -> vec2<f32> {
    let table = air_table_uniforms();
    let slope = select(table.slope.xy, table.slope.zw, behind);
    let position = slope.y * h / (slope.x * h + q);
    let row = floor(position);
    return vec2(row + select(0.0, f32(table.rows_front), behind), position - row - 0.5);
}

// c₀ + c₁ α + c₂ β + c₃ α² + c₄ α β + c₅ β², of which the last three coefficients share
// the fourth word: 11, 10 and 11 bits.
fn air_table_polynomial(cell: vec4<u32>, alpha: f32, beta: f32) -> f32 {
    let units = air_table_uniforms().units;
    let first = bitcast<vec3<f32>>(cell.xyz);
    let packed = bitcast<i32>(cell.w);
    let aa = f32(packed >> 21u) * units.x;
    let ab = f32((packed << 11u) >> 22u) * units.y;
    let bb = f32((packed << 21u) >> 21u) * units.z;
    return first.x + (alpha * (first.y + (alpha * aa + beta * ab)) + beta * (first.z + beta * bb));
}

// log2 of the phase function where tan(θ/2) = w/h.
fn air_table_phase(w: f32, h: f32) -> f32 {
    let table = air_table_uniforms();
    if table.is_constant == 1u {
        return table.constant;
    }
    // On the axis in front of the light both are 0, and so is b.
    let row = air_table_row(min(w, h), max(max(w, h), air_TABLE_LEAST), w > h);
    let index = min(u32(row.x), table.rows - 1u);
    let c = bitcast<vec4<f32>>(air_table_cell(table.radial * table.rows + index));
    return c.x + row.y * (c.y + row.y * (c.z + row.y * c.w));
}

// The cell of the first node of the rule that has `before` nodes in front of it.
fn air_table_rule(before: u32) -> u32 {
    let table = air_table_uniforms();
    return table.radial * table.rows + select(table.rows, 0u, table.is_constant == 1u) + before;
}

// The airlight of a near part: quadrature in the distance along the ray.
fn air_table_near(part: air_Scaled) -> f32 {
    let table = air_table_uniforms();
    let first = air_table_rule(table.nodes);
    let octaves = air_LOG2_E * part.sigma;
    var sum = 0.0;
    for (var i = 0u; i < table.near_nodes; i++) {
        let node = bitcast<vec2<f32>>(air_table_cell(first + i).xy);
        let way = node.x * part.length;
        let s = part.s + way;
        let d = air_distance(s, part.h);
        let q = abs(s) + d;
        let phase = air_table_phase(select(q, part.h, s < 0.0), select(part.h, q, s < 0.0));
        let growth = octaves * (way + (d - part.d_start));
        sum += node.y / (d * d) * air_exp2(phase - growth);
    }
    return air_exp2_times(part.length * sum, -part.octaves, -part.exponent);
}

// The airlight of a short part: quadrature in t from 0 to 1, a Möbius map of w = s + d.
fn air_table_short(part: air_Scaled) -> f32 {
    let table = air_table_uniforms();
    let front_a = part.s < 0.0;
    let front_b = part.end < 0.0;
    let d_a = part.d_start;
    let d_b = part.d_end;
    let h = part.h;
    let q_a = abs(part.s) + d_a;
    let q_b = abs(part.end) + d_b;
    // √(q d), of both ends.
    let root_a = d_a * sqrt(1.0 + abs(part.s) / d_a);
    let root_b = d_b * sqrt(1.0 + abs(part.end) / d_b);
    let roots = 0.5 / (root_a * root_b);
    var cos = roots * (h * h + q_a * q_b);
    var rise = q_a + q_b;
    if front_a != front_b {
        cos = roots * (h * rise);
        rise = h + q_a * (q_b / max(h, 0x1p-60 * q_b));
    }
    let bend = 2.0 * (1.0 - cos);
    let over = select(1.0, q_a, front_a);
    let under = select(1.0, select(h, q_b, front_b), front_a);
    let kappa = (root_b * over) / (root_a * under);
    let part_of_both = part.length / (d_a + d_b);
    let growth = air_LOG2_E * part.sigma * (part_of_both * ((d_a + part.s) + (d_b + part.end)));
    let w_a = select(q_a, h * (h / q_a), front_a);
    let w_b = select(q_b, h * (h / q_b), front_b);

    let first = air_table_rule(0u);
    var sum = 0.0;
    for (var i = 0u; i < table.nodes; i++) {
        let node = bitcast<vec2<f32>>(air_table_cell(first + i).xy);
        let near = kappa * (1.0 - node.x);
        let along = near + node.x;
        let bent = 1.0 - bend * (node.x * (1.0 - node.x));
        let phase = air_table_phase(w_a * near + w_b * node.x, h * along);
        sum += node.y / bent * air_exp2(phase - growth * (node.x / along));
    }
    let angle = roots * rise * part_of_both;
    return air_exp2_times(2.0 * angle * sum, -part.octaves, -part.exponent);
}
