-- SPDX-License-Identifier: Apache-2.0
SELECT pinned FROM enfilade.maps WHERE false;
SELECT pinned FROM enfilade.link_points WHERE false;
SELECT has_function_privilege('enfilade.rearrangement_image_but_pins(text, text, text)', 'execute');
