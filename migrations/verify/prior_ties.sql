-- SPDX-License-Identifier: Apache-2.0
SELECT tied_walls, joined_maps FROM enfilade.prior_maps WHERE false;
