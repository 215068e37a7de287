// One invocation per element, also where a dimension of the dispatch would exceed 65,535 workgroups.
const WORKGROUP: u32 = 64u;

fn invocation(group: vec3<u32>, groups: vec3<u32>, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + lane;
}
