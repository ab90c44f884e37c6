-- SPDX-License-Identifier: Apache-2.0
SELECT 1 / (1 - count(*)) FROM pg_trigger WHERE tgname = 'site_graphs_notify';
