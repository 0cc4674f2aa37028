// Nodes for an integrand along a segment: the shader's side of
// `Quadrature::nodes`.
//
// The part of the segment on either side of the foot point is an integral over
// o from 0 to some extent, and is cut into pieces there; each gets the nodes of
// one rule. What the variables mean is said in `side.rs` and
// `quadrature/piece.rs`. The start of the segment is not at the distance 1 here
// but at 1 to 3.
//
// Needs
//   fn air_quadrature_uniforms() -> air_Quadrature
//   fn air_quadrature_entry(index: u32) -> vec4<f32>

struct air_Quadrature {
    // The second and the first argument of air_phase.
    phase_parameters: vec4<f32>,
    phase_kind: u32,
    // Rules by growing number of nodes, an entry each: the most that a piece
    // may span, and the number of nodes. Behind them the nodes of all rules in
    // the same order: a position from 0 to 1 and a weight.
    rules: u32,
    // Optical depth, and growth of the distance, after which nothing is left.
    opacity: f32,
    far: f32,
    // Widths of the forward and the backward peak.
    finest_front: f32,
    finest_behind: f32,
    // Absorption behind the foot point, over the distance of the start from
    // the light, below which there is none.
    thin: f32,
    // The most that b and the exponent may change over a piece.
    growth: f32,
    fade: f32,
    // The number of rules that a piece may get without nodes for a pattern.
    plain_rules: u32,
    // What it was made for, 0 for a given number of nodes.
    tolerance: f32,
    padding: u32,
}

// What the integrand has besides the phase function and the extinction, over
// a segment without a rim inside. None of it is 0.
struct air_Pattern {
    // Nodes more on each piece: the sum of those below that apply, and what else
    // there is.
    extra: u32,
    // Optical depth beyond what a plain light needs: air_DEEPER for any pattern.
    deeper: f32,
    // Towards which the light fades by the fourth power of the distance, m; 0 if
    // it does not.
    range: f32,
}

// For an emission that is proportional to a cosine, for one between the rims of
// a spot, and for a light that fades towards its range. Why these are enough is
// said in `quadrature/profile.rs`.
const air_EXTRA_COSINE: u32 = 1u;
const air_EXTRA_SPOT: u32 = 3u;
const air_EXTRA_FADING: u32 = 1u;
const air_DEEPER: f32 = 6.0;
// The share of the range up to which fading does not matter.
const air_UNFADED: f32 = 0.02;

struct air_Node {
    // From the start of the segment, m.
    distance: f32,
    // Σ weight f ≈ ∫ f / d² dx, 1/m.
    weight: f32,
    // Of the angle of scattering.
    one_minus_cos: f32,
    one_plus_cos: f32,
    // How much more optical depth the way by the node has than that by the
    // start of the segment.
    depth: f32,
    // There are no more nodes, and this is none.
    done: bool,
}

const air_FRONT: u32 = 0u;
const air_BEHIND: u32 = 1u;
const air_THIN: u32 = 2u;

struct air_Side {
    kind: u32,
    a: f32,
    unit: f32,
    base: f32,
    scale: f32,
    depth: f32,
    rate: f32,
    extent: f32,
    finest: f32,
    offset: f32,
    // base + o below which the light fades with the distance.
    faded: f32,
}

struct air_Piece {
    start: f32,
    width: f32,
    // b and its change.
    b: f32,
    b_change: f32,
    alpha: f32,
}

// What is left to look at.
struct air_Nodes {
    part: air_Scaled,
    side: air_Side,
    piece: air_Piece,
    // Where the next piece starts; at the extent of the side or behind it there
    // is none.
    start: f32,
    // Whether the part behind the foot point has been begun.
    last: bool,
    // The nodes that are left of the piece.
    node: u32,
    nodes: u32,
    length: f32,
    pattern: air_Pattern,
}

// No node if the segment is empty or meets the light: see the kind of `part`. How
// much light is left at its start is not asked: the integrand is the caller's.
fn air_nodes(sigma_t: f32, segment: air_Segment) -> air_Nodes {
    return air_pattern_nodes(sigma_t, segment, air_Pattern());
}

// The same for an integrand with a pattern, which is the caller's as well.
fn air_pattern_nodes(sigma_t: f32, segment: air_Segment, pattern: air_Pattern) -> air_Nodes {
    return air_nodes_of(air_scaled_lengths(sigma_t, segment), segment, pattern);
}

// Of a segment that has been scaled.
fn air_nodes_of(part: air_Scaled, segment: air_Segment, pattern: air_Pattern) -> air_Nodes {
    var nodes: air_Nodes;
    nodes.part = part;
    nodes.pattern = pattern;
    nodes.pattern.range = air_scale(pattern.range, -part.exponent);
    // An infinite length counts as air_FAR, whose bits are the next smaller.
    nodes.length = bitcast<f32>(clamp(bitcast<i32>(segment.length), 0, 0x7f7fffff));
    nodes.last = nodes.part.kind != air_ORDINARY;
    if !nodes.last && nodes.part.s < 0.0 {
        nodes.side = air_front(nodes.part, nodes.pattern);
    }
    return nodes;
}

fn air_next_node(nodes: ptr<function, air_Nodes>) -> air_Node {
    var node = air_next_scaled_node(nodes);
    let exponent = (*nodes).part.exponent;
    node.weight = air_scale(node.weight, -exponent);
    // Rounding may have taken it past the end.
    node.distance = min(air_scale(max(node.distance, 0.0), exponent), (*nodes).length);
    return node;
}

// In units of the segment.
fn air_next_scaled_node(nodes: ptr<function, air_Nodes>) -> air_Node {
    if (*nodes).node >= (*nodes).nodes && !air_next_piece(nodes) {
        return air_Node(0.0, 0.0, 1.0, 1.0, 0.0, true);
    }
    let node = air_quadrature_entry((*nodes).node);
    (*nodes).node += 1u;
    return air_node_at((*nodes).side, (*nodes).piece, node.x, node.y);
}

// Whether there is one more.
fn air_next_piece(nodes: ptr<function, air_Nodes>) -> bool {
    if (*nodes).start >= (*nodes).side.extent {
        if (*nodes).last {
            return false;
        }
        (*nodes).last = true;
        (*nodes).start = 0.0;
        let depth = (*nodes).side.depth + (*nodes).side.rate * (*nodes).side.extent;
        (*nodes).side.extent = 0.0;
        if (*nodes).part.end > 0.0 {
            (*nodes).side = air_behind((*nodes).part, depth, (*nodes).pattern);
        }
        if (*nodes).side.extent <= 0.0 {
            return false;
        }
    }
    let side = (*nodes).side;
    let start = (*nodes).start;
    let end = air_piece_end(side, start);
    (*nodes).start = end;

    var piece: air_Piece;
    piece.start = start;
    piece.width = end - start;
    piece.b = side.unit * (side.base + start);
    piece.b_change = side.unit * piece.width;
    if side.base + start < side.faded {
        // As b, but on the axis as well.
        piece.alpha = sqrt((side.base + start) / (side.base + end));
    } else {
        let near = piece.b + side.finest;
        piece.alpha = sqrt(near / (near + piece.b_change));
    }
    (*nodes).piece = piece;
    let rule = air_rule(air_span(side, piece), (*nodes).pattern.extra);
    (*nodes).node = rule.x;
    (*nodes).nodes = rule.x + rule.y;
    return true;
}

fn air_front(part: air_Scaled, pattern: air_Pattern) -> air_Side {
    var length = part.length;
    var end = part.end;
    var distance = part.d_end;
    if end >= 0.0 {
        length = -part.s;
        end = 0.0;
        distance = part.h;
    }
    var side: air_Side;
    let first = 1.0 / (part.d_start - part.s);
    let ratio = (part.d_start - part.s) / (distance - end);
    side.kind = air_FRONT;
    side.a = 1.0;
    side.unit = part.h * first;
    side.base = 1.0;
    side.scale = first;
    side.rate = (part.sigma * part.h) * side.unit;
    side.extent = length * ((1.0 + ratio) / (part.d_start + distance));
    side.finest = air_quadrature_uniforms().finest_front;
    side.faded = air_faded(side, pattern);
    return air_cut_off(side, pattern);
}

// `depth` is the exponent at the foot point.
fn air_behind(part: air_Scaled, depth: f32, pattern: air_Pattern) -> air_Side {
    let quadrature = air_quadrature_uniforms();
    var side: air_Side;
    var length = part.length;
    var start = part.s;
    var distance = part.d_start;
    if part.s < 0.0 {
        length = part.end;
        start = 0.0;
        distance = part.h;
        side.offset = -part.s;
    }
    let first = start + distance;
    let last = part.end + part.d_end;
    let both = distance + part.d_end;
    side.scale = 1.0 / first;
    side.depth = depth;
    if part.sigma * part.d_start < quadrature.thin {
        side.kind = air_THIN;
        side.a = 1.0;
        side.unit = part.h * side.scale;
        side.base = first / last;
        side.extent = length * ((side.base + 1.0) / both);
        side.finest = quadrature.finest_behind;
        side.faded = air_faded(side, pattern);
        return side;
    }
    side.kind = air_BEHIND;
    side.a = part.h * side.scale;
    side.unit = 1.0;
    side.base = 1.0;
    side.rate = part.sigma * first;
    // An f32 can square 2^60 and twice as much of it.
    let far = min(quadrature.far * exp(pattern.deeper), 0x1p+60);
    side.extent = far;
    if last < far * first {
        side.extent = min(length * ((1.0 + last / first) / both), far);
    }
    return air_cut_off(side, pattern);
}

fn air_faded(side: air_Side, pattern: air_Pattern) -> f32 {
    return select(0.0, 0.5 / (side.scale * air_UNFADED * pattern.range), pattern.range > 0.0);
}

// What lies behind the opacity is left out.
fn air_cut_off(side: air_Side, pattern: air_Pattern) -> air_Side {
    let left = air_quadrature_uniforms().opacity + pattern.deeper - side.depth;
    var shorter = side;
    if side.rate * side.extent > left {
        shorter.extent = left / side.rate;
    }
    return shorter;
}

// The end of a piece over which b and the exponent change by little enough.
fn air_piece_end(side: air_Side, start: f32) -> f32 {
    let quadrature = air_quadrature_uniforms();
    let left = side.extent - start;
    let most_depth = max(side.rate * start, quadrature.fade);
    var of_b = side.unit * left / ((quadrature.growth - 1.0) * (side.unit * (side.base + start) + side.finest));
    if side.base + start < side.faded {
        of_b = left / ((quadrature.growth - 1.0) * (side.base + start));
    }
    let pieces = max(of_b, side.rate * left / most_depth);
    // A little more at the end, to leave no sliver.
    return select(side.extent, start + left / pieces, pieces > 1.1);
}

// What the choice of a rule depends on: `1/ρ` in front and behind, and the
// change of the exponent.
fn air_span(side: air_Side, piece: air_Piece) -> vec3<f32> {
    // tan(π/8)
    let tangent = 0.414213568;
    let k = abs((1.0 - piece.alpha) / (1.0 + piece.alpha));
    let depth = side.rate * piece.width;
    let behind = k / (1.0 + sqrt(max(1.0 - k * k, 0.0)));
    if side.kind == air_BEHIND {
        return vec3(0.0, behind, depth);
    }
    let fades = side.base + piece.start < side.faded;
    let shifted = k / (tangent + sqrt(tangent * tangent + k * k));
    return vec3(shifted, select(0.0, behind, fades), depth);
}

// The first node of the smallest rule for a piece, and the number of its nodes.
fn air_rule(span: vec3<f32>, extra: u32) -> vec2<u32> {
    let rules = air_quadrature_uniforms().rules;
    let plain = air_quadrature_uniforms().plain_rules;
    var first = rules;
    // The rule to be taken, once one is found that is good enough.
    var taken = rules - 1u;
    for (var i = 0u; i < rules; i++) {
        let rule = air_quadrature_entry(i);
        let nodes = u32(rule.w);
        if i < plain && (i + 1u == plain || all(span <= rule.xyz)) {
            taken = min(taken, i + extra);
        }
        if i == taken {
            return vec2(first, nodes);
        }
        first += nodes;
    }
    return vec2(0u);
}

// The node at t, from 0 to 1, of a weight in t.
fn air_node_at(side: air_Side, piece: air_Piece, t: f32, weight: f32) -> air_Node {
    let denominator = 1.0 - (1.0 - piece.alpha) * t;
    let jacobian = piece.alpha / (denominator * denominator);
    // From 0 to 1 over the piece.
    let f = piece.alpha * t / denominator;
    let o = piece.start + piece.width * f;
    let b = piece.b + piece.b_change * f;
    let squares = vec2(side.a * side.a, b * b);
    let per_square = 1.0 / (squares.x + squares.y);
    let cosines = 2.0 * per_square * select(squares.yx, squares, side.kind == air_THIN);

    // On every side x grows by half of what s + d and d − s do.
    let half = 0.5 / side.scale;
    let rest = side.base + o;
    let unit2 = side.unit * side.unit;
    var way = o * (half * unit2 + half / rest);
    if side.kind == air_BEHIND {
        way = o * (half + half * (side.a * side.a) / rest);
    } else if side.kind == air_THIN {
        way = max(side.extent - o, 0.0) * (half * unit2 + half / rest);
    }
    return air_Node(
        side.offset + way,
        2.0 * side.scale * piece.width * jacobian * weight * per_square,
        cosines.x,
        cosines.y,
        side.depth + side.rate * o,
        false,
    );
}
