// Nodes for an integrand along a segment: the shader's side of
// `Quadrature::nodes`.
//
// The part of the segment on either side of the foot point (its side) is an integral
// over o from 0 to the side's extent. A side is cut into pieces, each of which gets the
// nodes of one rule. `side.rs` and `quadrature/piece.rs` derive the variables. There the
// unit of length is the distance between the start of the segment and the light; here
// it is the power of two in which that distance is between 1 and 3.
//
// Needs
//   fn air_quadrature_uniforms() -> air_Quadrature
//   fn air_quadrature_entry(index: u32) -> vec4<f32>    an entry, as `rules` tells

struct air_Quadrature {
    // The second and the first argument of air_phase.
    phase_parameters: vec4<f32>,
    phase_kind: u32,
    // The number of rules. The entries begin with one for each rule, by growing number
    // of nodes: the most that a piece may span (xyz, as air_span tells it), and the
    // number of nodes (w). Behind them are the nodes of all rules in the same order: a
    // position from 0 to 1 (x) and a weight (y).
    rules: u32,
    // The optical depth behind which nothing is left, and the growth of the distance
    // behind which nothing is left.
    opacity: f32,
    far: f32,
    // Widths of the forward and the backward peak of the phase function.
    finest_front: f32,
    finest_behind: f32,
    // Behind the foot point absorption is ignored if the optical depth of the distance
    // between the start and the light is below this.
    thin: f32,
    // The most that b may grow over a piece, as a factor, and the most that the exponent
    // may grow.
    growth: f32,
    fade: f32,
    // How many of the rules a piece may get if the integrand has no pattern; the others
    // are for the extra nodes of a pattern.
    plain_rules: u32,
    // The relative tolerance it was made for; 0 if a number of nodes was given instead.
    tolerance: f32,
    padding: u32,
}

// What the integrand has besides the phase function and the extinction, over a segment
// that crosses no rim of a spot. All zeros stand for nothing.
struct air_Pattern {
    // How many more nodes each piece needs: the sum of the constants below that apply,
    // and those for what the caller's integrand has besides.
    extra: u32,
    // Optical depth beyond what a plain light needs: air_DEEPER for any pattern.
    deeper: f32,
    // The range towards which the light fades by the fourth power of the distance, m;
    // 0 if it does not fade.
    range: f32,
}

// Extra nodes for an emission that is proportional to a cosine, for one between the rims
// of a spot, and for a light that fades towards its range. `quadrature/profile.rs` says
// why these are enough.
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
    // 1 − cos θ and 1 + cos θ of the angle of scattering.
    one_minus_cos: f32,
    one_plus_cos: f32,
    // The optical depth of the way from the light by the node to the eye, less that of
    // the way by the start of the segment.
    depth: f32,
    // Whether there are no more nodes; this is none then.
    done: bool,
}

// Kinds of sides: in front of the foot point, behind it, and behind it without
// absorption.
const air_FRONT: u32 = 0u;
const air_BEHIND: u32 = 1u;
const air_THIN: u32 = 2u;

// ∫ p e^{−Y} dx / d² = ∫ 2 scale p e^{−Y} / (a² + b²) do for o from 0 to `extent`, with
// b = unit (base + o) and Y = depth + rate o; see `side.rs`.
struct air_Side {
    kind: u32,
    a: f32,
    unit: f32,
    base: f32,
    scale: f32,
    depth: f32,
    rate: f32,
    extent: f32,
    // The scale of b below which the integrand no longer changes.
    finest: f32,
    // The way from the start of the segment to the start of the side.
    offset: f32,
    // base + o below which the light fades with the distance; 0 if it does not.
    faded: f32,
}

// A piece of a side.
struct air_Piece {
    // Of o.
    start: f32,
    width: f32,
    // b at the start, and by how much it grows.
    b: f32,
    b_change: f32,
    // The parameter of the Möbius map that spreads the nodes; see air_node_at.
    alpha: f32,
}

// The nodes of a segment that have not been handed out.
struct air_Nodes {
    part: air_Scaled,
    side: air_Side,
    piece: air_Piece,
    // The o at which the next piece starts; the side has no more pieces where this is
    // its extent or more.
    start: f32,
    // Whether the side behind the foot point has been begun.
    last: bool,
    // The next entry of the piece's rule, and the one behind its last.
    node: u32,
    nodes: u32,
    length: f32,
    pattern: air_Pattern,
}

// The nodes of a segment. There are none if the segment is empty or meets the light,
// which the kind of `part` tells. What dims the light on the way by the start of the
// segment is left to the caller, whose integrand this is.
fn air_nodes(sigma_t: f32, segment: air_Segment) -> air_Nodes {
    return air_pattern_nodes(sigma_t, segment, air_Pattern());
}

// The same for an integrand that has a pattern.
fn air_pattern_nodes(sigma_t: f32, segment: air_Segment, pattern: air_Pattern) -> air_Nodes {
    return air_nodes_of(air_scaled_lengths(sigma_t, segment), segment, pattern);
}

// The nodes of a segment that has been scaled.
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

// The next node, in metres.
fn air_next_node(nodes: ptr<function, air_Nodes>) -> air_Node {
    var node = air_next_scaled_node(nodes);
    let exponent = (*nodes).part.exponent;
    node.weight = air_scale(node.weight, -exponent);
    // Rounding may have taken it past the end.
    node.distance = min(air_scale(max(node.distance, 0.0), exponent), (*nodes).length);
    return node;
}

// The next node, in the segment's unit of length.
fn air_next_scaled_node(nodes: ptr<function, air_Nodes>) -> air_Node {
    if (*nodes).node >= (*nodes).nodes && !air_next_piece(nodes) {
        return air_Node(0.0, 0.0, 1.0, 1.0, 0.0, true);
    }
    let node = air_quadrature_entry((*nodes).node);
    (*nodes).node += 1u;
    return air_node_at((*nodes).side, (*nodes).piece, node.x, node.y);
}

// Goes on to the next piece, if there is one.
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
        // base + o is proportional to b, and works on the axis as well, where b is 0.
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

// The side in front of the foot point, of a segment that begins there.
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

// The side behind the foot point; `depth` is the exponent where it begins.
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
    // The square of this, and of twice this, is still an f32.
    let far = min(quadrature.far * exp(pattern.deeper), 0x1p+60);
    side.extent = far;
    if last < far * first {
        side.extent = min(length * ((1.0 + last / first) / both), far);
    }
    return air_cut_off(side, pattern);
}

// The base + o below which the light of a pattern fades; 0 if it does not.
fn air_faded(side: air_Side, pattern: air_Pattern) -> f32 {
    return select(0.0, 0.5 / (side.scale * air_UNFADED * pattern.range), pattern.range > 0.0);
}

// The side without what lies behind the opacity.
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
    // The last piece may be a tenth longer, so that no sliver is left.
    return select(side.extent, start + left / pieces, pieces > 1.1);
}

// What the choice of a rule depends on: 1/ρ in front of the foot point and 1/ρ behind it
// (see `Span` in `quadrature/piece.rs`), and the change of the exponent.
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

// The smallest rule that is good enough for a piece of such a span: the entry of its
// first node, and the number of its nodes.
fn air_rule(span: vec3<f32>, extra: u32) -> vec2<u32> {
    let rules = air_quadrature_uniforms().rules;
    let plain = air_quadrature_uniforms().plain_rules;
    var first = rules;
    // The rule to be taken; the last one until a smaller one is good enough.
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

// The node at t, from 0 to 1, of a piece; `weight` is that of t. The Möbius map
// f = α t / (1 − (1 − α) t) crowds nodes where the integrand changes fastest.
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

    // x = s + constant, and s is half the difference of s + d and d − s; both are
    // elementary in o on every side.
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
