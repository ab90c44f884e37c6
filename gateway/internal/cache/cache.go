// SPDX-License-Identifier: Apache-2.0

// Package cache keeps what was read last.
package cache

import (
	"container/list"
	"sync"
	"time"
)

// Cache keeps values of at most so many bytes in all, each for so long. Its keys should name content, so that nothing in
// it is ever wrong. Thread-safe.
type Cache[V any] struct {
	limit   int // bytes
	kept    time.Duration
	bytesOf func(V) int

	mutex   sync.Mutex
	bytes   int
	entries map[string]*list.Element
	order   list.List // of *cached[V], the last read first
}

type cached[V any] struct {
	key   string
	value V
	until time.Time
}

// New makes an empty one.
func New[V any](limit int, kept time.Duration, bytesOf func(V) int) *Cache[V] {
	return &Cache[V]{limit: limit, kept: kept, bytesOf: bytesOf, entries: map[string]*list.Element{}}
}

// Get a value that is kept.
func (c *Cache[V]) Get(key string) (V, bool) {
	var none V
	c.mutex.Lock()
	defer c.mutex.Unlock()
	element, found := c.entries[key]
	if !found {
		return none, false
	}
	entry := element.Value.(*cached[V])
	if time.Now().After(entry.until) {
		c.drop(element)
		return none, false
	}
	c.order.MoveToFront(element)
	return entry.value, true
}

// Put a value in the place of that which has been read least lately.
func (c *Cache[V]) Put(key string, value V) {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	if element, found := c.entries[key]; found {
		c.drop(element)
	}
	c.entries[key] = c.order.PushFront(&cached[V]{key, value, time.Now().Add(c.kept)})
	c.bytes += c.bytesOf(value)
	for c.bytes > c.limit {
		c.drop(c.order.Back())
	}
}

func (c *Cache[V]) drop(element *list.Element) {
	entry := c.order.Remove(element).(*cached[V])
	delete(c.entries, entry.key)
	c.bytes -= c.bytesOf(entry.value)
}
