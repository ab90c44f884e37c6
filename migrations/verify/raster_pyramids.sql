-- SPDX-License-Identifier: Apache-2.0
SELECT display_only, lattice_column, lattice_row, thumbnail_zoom, thumbnail_column, thumbnail_row, thumbnail_width,
  thumbnail_cells FROM enfilade.raster_pyramids WHERE false;
SELECT zoom, tile_row, tile_column, sha256 FROM enfilade.raster_pyramid_tiles WHERE false;
