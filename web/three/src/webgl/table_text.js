// GLSL that reads the table of objects (scene/table.js).

/** Texels of one object: see ObjectTable. */
export const COLUMNS = 15;
export const ROWS = 1024;
export const table = `
uniform highp sampler2D hlTable;
vec4 hlCell(int row, int column)
{
    return texelFetch(hlTable, ivec2((row / ${ROWS}) * ${COLUMNS} + column, row % ${ROWS}), 0);
}
// From the world to the space of the bake that an object belongs to.
mat4 hlBakeFromWorld(int row)
{
    int place = int(hlCell(row, 1).w);
    return mat4(hlCell(place, 0), hlCell(place, 1), hlCell(place, 2), hlCell(place, 3));
}
`;
