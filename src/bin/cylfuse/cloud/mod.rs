//! Point cloud files: PLY, PCD and text.

mod pcd;
mod ply;
mod text;

pub use pcd::write as write_pcd;
pub use ply::{write as write_ply, write_numbered as write_numbered_ply};

use crate::failure::Failure;
use cylfuse::observations::PointsView;
use std::path::Path;

/// The coordinates of a file, as wide as they are stored: the width tells how many digits are real.
#[derive(Debug, Clone, PartialEq)]
pub enum Cloud {
    /// 32-bit floats.
    F32(Vec<[f32; 3]>),
    /// 64-bit floats, integers and text.
    F64(Vec<[f64; 3]>),
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudFile {
    /// The points, row by row where they are organised.
    pub points: Cloud,
    /// The columns of an organised cloud.
    columns: Option<usize>,
}

impl From<Cloud> for CloudFile {
    fn from(points: Cloud) -> Self {
        Self { points, columns: None }
    }
}

impl CloudFile {
    /// Reads a file of the kind that its name says.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
        let parse = match extension.as_str() {
            "ply" => |bytes: &[u8]| ply::parse(bytes).map(Self::from),
            "pcd" => pcd::parse,
            "xyz" | "txt" | "csv" | "asc" => |bytes: &[u8]| text::parse(bytes).map(Self::from),
            _ => {
                let reason = "is no known kind of point cloud; name a .ply, .pcd or .xyz file";
                return Err(Failure::bad_cloud(path, reason));
            }
        };
        let bytes = std::fs::read(path).map_err(|error| Failure::not_readable(path, &error))?;
        if bytes.is_empty() {
            return Err(Failure::bad_cloud(path, "is an empty file"));
        }
        parse(&bytes).map_err(|reason| Failure::bad_cloud(path, reason))
    }

    /// The coordinates for the library.
    pub fn view(&self) -> cylfuse::error::Result<PointsView<'_>> {
        let list = match &self.points {
            Cloud::F32(points) => PointsView::from_f32(points),
            Cloud::F64(points) => PointsView::from_f64(points),
        };
        self.columns.map_or(Ok(list), |columns| list.organised(columns))
    }
}

impl Cloud {
    /// The coordinates as doubles.
    pub fn to_f64(&self) -> Vec<[f64; 3]> {
        match self {
            Cloud::F32(points) => points.iter().map(|point| point.map(f64::from)).collect(),
            Cloud::F64(points) => points.clone(),
        }
    }
}

/// Little-endian bytes of points, x y z each.
fn little_endian(points: &[[f32; 3]]) -> Vec<u8> {
    points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}
