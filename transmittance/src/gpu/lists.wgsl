// Segments grouped by texel: the source `SegmentLists`. Needs the variables
//   avsm_lists: avsm_Lists
//   avsm_offsets: array<u32>
//   avsm_numbers: array<f32>

struct avsm_Lists {
    // Texels of the map, and the segments of all lists.
    width: u32,
    height: u32,
    segments: u32,
}

// Where the list of a texel begins and ends. Empty beside the map, and where the offsets
// are not in order.
fn avsm_list(texel: vec2<u32>) -> vec2<u32> {
    if texel.x >= avsm_lists.width || texel.y >= avsm_lists.height {
        return vec2(0u);
    }
    let i = texel.y * avsm_lists.width + texel.x;
    let ends = vec2(avsm_offsets[i], avsm_offsets[i + 1u]);
    return select(vec2(0u), ends, ends.x <= ends.y && ends.y <= avsm_lists.segments);
}

fn avsm_lists_segment_count(texel: vec2<u32>) -> u32 {
    let ends = avsm_list(texel);
    return ends.y - ends.x;
}

fn avsm_lists_segment(texel: vec2<u32>, index: u32) -> avsm_Segment {
    let first = (avsm_list(texel).x + index) * (2u + avsm_CHANNELS);
    var segment: avsm_Segment;
    segment.entry = avsm_numbers[first];
    segment.exit = avsm_numbers[first + 1u];
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        segment.optical_depth[c] = avsm_numbers[first + 2u + c];
    }
    return segment;
}
