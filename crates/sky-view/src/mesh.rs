//! The terrain as a mesh around the camera: nested squares of cells, each twice as coarse as the one
//! in its middle, so that a cell fills about as many pixels near and far.
//!
//! A square moves in steps of two of its cells, so that its corners stay where they are on the ground
//! and nothing swims; only then are its heights computed anew, by the function that
//! [`sky_render::terrain`] marches through. Toward its edge a square takes the shape of the coarser one,
//! which leaves no cracks. East and north are distances along the ground; the shader bends them over
//! the Earth.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use sky_core::quantity::single;
use sky_render::terrain::ridges;

/// Cells across a square.
pub const CELLS: u16 = 192;
/// Corners across a square.
pub const CORNERS: usize = CELLS as usize + 1;
/// Squares, from 3.8 km to 2000 km across.
pub const LEVELS: usize = 10;
/// A cell of the finest square \[km\].
const FINEST_KM: f64 = 0.02;
/// Corners beyond the edge whose heights the slopes need.
const MARGIN: u8 = 3;
/// Heights across a square.
const HEIGHTS: usize = CORNERS + 2 * MARGIN as usize;
/// Cells at the edge over which a square takes the coarser one's shape.
const BLEND: u8 = 24;
/// Least share of the height above the ground that is worth a cell.
const SHARE: f64 = 0.004;

/// A corner: what is not told by its place in the square.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Corner {
    /// Height of the ground \[km\].
    pub height_km: f32,
    /// Slopes toward east and north.
    pub slope: [f32; 2],
}

/// A square as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Its place among the squares, 0 for the finest.
    pub level: usize,
    /// Its middle, from the camera to the east and north \[km\].
    pub middle_km: [f32; 2],
    /// A side of a cell \[km\].
    pub cell_km: f32,
    /// First cell of the hole for the finer square, where there is one.
    pub hole: Option<[u16; 2]>,
}

/// The squares, and where they lie.
#[derive(Debug)]
pub struct Mesh {
    /// Middles of the squares in their cells, even numbers; `None` before the first use.
    middles: [Option<[i32; 2]>; LEVELS],
    finest: usize,
    heights: Vec<f32>,
    corners: Vec<Corner>,
}

impl Default for Mesh {
    fn default() -> Self {
        Self {
            middles: [None; LEVELS],
            finest: 0,
            heights: vec![0.0; HEIGHTS * HEIGHTS],
            corners: vec![Corner::default(); CORNERS * CORNERS],
        }
    }
}

/// A side of a cell \[km\].
fn cell_km(level: usize) -> f64 {
    FINEST_KM * f64::from(1_u32 << level)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "places on Earth, in cells of 20 m and more"
)]
fn even_below(place_km: f64, cell_km: f64) -> i32 {
    2 * (place_km / (2.0 * cell_km)).floor() as i32
}

impl Mesh {
    /// Brings the squares to the camera: `upload` gets the corners of each that has moved.
    pub fn follow(
        &mut self,
        place_km: [f64; 2],
        above_ground_km: f64,
        mut upload: impl FnMut(usize, &[Corner]),
    ) {
        self.finest = (0..LEVELS - 2)
            .find(|&level| cell_km(level) >= SHARE * above_ground_km)
            .unwrap_or(LEVELS - 2);
        for level in self.finest..LEVELS {
            let middle = place_km.map(|place| even_below(place, cell_km(level)));
            if self.middles[level] != Some(middle) {
                self.middles[level] = Some(middle);
                self.compute(middle, cell_km(level));
                upload(level, &self.corners);
            }
        }
    }

    /// Forgets what was uploaded.
    pub const fn forget(&mut self) {
        self.middles = [None; LEVELS];
    }

    /// What is to be drawn, after [`Self::follow`].
    pub fn squares(&self, place_km: [f64; 2]) -> impl Iterator<Item = Square> {
        (self.finest..LEVELS).filter_map(move |level| {
            let middle = self.middles[level]?;
            let cell = cell_km(level);
            let hole = (level > self.finest).then(|| {
                // the finer square's middle, in cells of this one, is that of this or one more
                core::array::from_fn(|axis| {
                    let finer = even_below(place_km[axis], 0.5 * cell) / 2;
                    CELLS / 4 + u16::from(finer > middle[axis])
                })
            });
            Some(Square {
                level,
                middle_km: core::array::from_fn(|axis| {
                    single(f64::from(middle[axis]) * cell - place_km[axis])
                }),
                cell_km: single(cell),
                hole,
            })
        })
    }

    fn compute(&mut self, middle: [i32; 2], cell_km: f64) {
        let first = middle.map(|m| m - i32::from(CELLS / 2) - i32::from(MARGIN));
        let place = |axis: usize, i: i32| single(f64::from(first[axis] + i) * cell_km);
        self.heights
            .par_chunks_exact_mut(HEIGHTS)
            .enumerate()
            .for_each(|(j, row)| {
                let north = place(1, i32::try_from(j).unwrap_or(0));
                for (height, i) in row.iter_mut().zip(0..) {
                    *height = ridges(place(0, i), north);
                }
            });
        let field = Field {
            heights: &self.heights,
            cell_km: single(cell_km),
        };
        self.corners
            .par_chunks_exact_mut(CORNERS)
            .enumerate()
            .for_each(|(j, row)| {
                for (i, corner) in row.iter_mut().enumerate() {
                    *corner = field.blended(i, j);
                }
            });
    }
}

/// Heights of a square with its margin.
struct Field<'a> {
    heights: &'a [f32],
    cell_km: f32,
}

impl Field<'_> {
    /// A corner of the grid with every `step`th height; places count from the square's first corner.
    fn corner(&self, i: usize, j: usize, step: usize) -> Corner {
        let (i, j) = (i + usize::from(MARGIN), j + usize::from(MARGIN));
        let at = |i: usize, j: usize| self.heights[j * HEIGHTS + i];
        let across = 2.0 * f32::from(u8::try_from(step).unwrap_or(1)) * self.cell_km;
        Corner {
            height_km: at(i, j),
            slope: [
                (at(i + step, j) - at(i - step, j)) / across,
                (at(i, j + step) - at(i, j - step)) / across,
            ],
        }
    }

    /// A corner, the nearer the edge the more like the coarser square there.
    fn blended(&self, i: usize, j: usize) -> Corner {
        let last = CORNERS - 1;
        let to_edge = i.min(j).min(last - i).min(last - j);
        let fine = self.corner(i, j, 1);
        if to_edge >= usize::from(BLEND) {
            return fine;
        }
        // the coarser square has the even corners; between them it is straight
        let (low, high) = ([i - i % 2, j - j % 2], [i + i % 2, j + j % 2]);
        let a = self.corner(low[0], low[1], 2);
        let b = self.corner(high[0], high[1], 2);
        let coarse = mix(a, b, 0.5);
        mix(
            coarse,
            fine,
            f32::from(u8::try_from(to_edge).unwrap_or(0)) / f32::from(BLEND),
        )
    }
}

fn mix(a: Corner, b: Corner, share: f32) -> Corner {
    let mix = |a: f32, b: f32| a + share * (b - a);
    Corner {
        height_km: mix(a.height_km, b.height_km),
        slope: core::array::from_fn(|axis| mix(a.slope[axis], b.slope[axis])),
    }
}

/// Corners of the triangles of a square, two for each cell that is not in the hole.
pub fn triangles(hole: Option<[u16; 2]>) -> impl Iterator<Item = u16> {
    let is_open = move |x: u16, y: u16| {
        hole.is_none_or(|hole| {
            !((hole[0]..hole[0] + CELLS / 2).contains(&x)
                && (hole[1]..hole[1] + CELLS / 2).contains(&y))
        })
    };
    (0..CELLS)
        .flat_map(|y| (0..CELLS).map(move |x| (x, y)))
        .filter(move |&(x, y)| is_open(x, y))
        .flat_map(|(x, y)| {
            let across = CELLS + 1;
            let corner = y * across + x;
            let (right, above) = (corner + 1, corner + across);
            [corner, right, above + 1, corner, above + 1, above]
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of a place with all their corners.
    fn squares(place_km: [f64; 2], above_km: f64) -> Vec<(Square, Vec<Corner>)> {
        let mut mesh = Mesh::default();
        let mut corners = vec![Vec::new(); LEVELS];
        mesh.follow(place_km, above_km, |level, c| corners[level] = c.to_vec());
        mesh.squares(place_km)
            .map(|square| (square, corners[square.level].clone()))
            .collect()
    }

    #[test]
    fn heights_are_those_of_the_terrain() {
        let place = [12.34, -56.78];
        let (square, corners) = squares(place, 0.0)[0].clone();
        let middle = corners[CORNERS * (CORNERS / 2) + CORNERS / 2];
        let at = |axis: usize| single(place[axis]) + square.middle_km[axis];
        assert!((middle.height_km - ridges(at(0), at(1))).abs() < 1e-3);
    }

    #[test]
    fn the_hole_is_where_the_finer_square_lies() {
        for i in 0..40 {
            let place = [0.37 * f64::from(i) - 5.0, 3.0 - 0.21 * f64::from(i)];
            let found = squares(place, 1.0);
            assert!(found[0].0.hole.is_none());
            for pair in found.windows(2) {
                let (fine, coarse) = (pair[0].0, pair[1].0);
                let hole = coarse.hole.expect("a hole");
                let half = f32::from(CELLS / 2);
                for (axis, cell) in hole.into_iter().enumerate() {
                    let from = coarse.middle_km[axis] + (f32::from(cell) - half) * coarse.cell_km;
                    let fine_from = fine.middle_km[axis] - half * fine.cell_km;
                    assert!(
                        (from - fine_from).abs() < 1e-3 * coarse.cell_km,
                        "{place:?}"
                    );
                }
            }
        }
    }

    /// Along its edge a square is as high as the coarser one, between its corners too.
    #[test]
    fn squares_meet_without_a_crack() {
        let found = squares([1.234, 5.678], 0.0);
        for pair in found.windows(2) {
            let ((_, fine), (coarse_square, coarse)) = (&pair[0], &pair[1]);
            let hole = coarse_square.hole.expect("a hole").map(usize::from);
            for (i, corner) in fine.iter().enumerate().take(CORNERS) {
                let at = |i: usize| coarse[hole[1] * CORNERS + hole[0] + i].height_km;
                let expected = 0.5 * (at(i / 2) + at(i.div_ceil(2)));
                assert!((corner.height_km - expected).abs() < 1e-5, "corner {i}");
            }
        }
    }

    #[test]
    fn a_step_moves_only_what_has_to() {
        let mut mesh = Mesh::default();
        let mut count = 0;
        mesh.follow([0.001, 0.001], 0.0, |_, _| count += 1);
        assert_eq!(count, LEVELS);
        mesh.follow([0.002, 0.002], 0.0, |_, _| count += 1);
        assert_eq!(count, LEVELS);
        mesh.follow([0.05, 0.002], 0.0, |_, _| count += 1);
        assert_eq!(count, LEVELS + 1);
    }

    #[test]
    fn triangles_fill_all_but_the_hole() {
        let cells = usize::from(CELLS) * usize::from(CELLS);
        assert_eq!(triangles(None).count(), 6 * cells);
        assert_eq!(triangles(Some([48, 49])).count(), 6 * (cells - cells / 4));
        assert!(triangles(None).all(|corner| usize::from(corner) < CORNERS * CORNERS));
    }
}
