// SPDX-License-Identifier: Apache-2.0

// As addresses have digests.
export const hex = (bytes: Uint8Array) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
