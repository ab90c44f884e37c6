// SPDX-License-Identifier: Apache-2.0

package rasters

import (
	"container/list"
	"sync"
	"time"
)

// cache keeps the tiles that were read last. Its keys name content, so that nothing in it is ever wrong; after `kept` the
// server is asked again whether the site still has the tile.
type cache struct {
	limit int // bytes
	kept  time.Duration

	mutex   sync.Mutex
	bytes   int
	entries map[string]*list.Element
	order   list.List // of *cached, the last read first
}

type cached struct {
	key     string
	content []byte
	until   time.Time
}

func newCache(limit int, kept time.Duration) *cache {
	return &cache{limit: limit, kept: kept, entries: map[string]*list.Element{}}
}

func (c *cache) get(key string) ([]byte, bool) {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	element, found := c.entries[key]
	if !found {
		return nil, false
	}
	entry := element.Value.(*cached)
	if time.Now().After(entry.until) {
		c.drop(element)
		return nil, false
	}
	c.order.MoveToFront(element)
	return entry.content, true
}

func (c *cache) put(key string, content []byte) {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	if element, found := c.entries[key]; found {
		c.drop(element)
	}
	c.entries[key] = c.order.PushFront(&cached{key, content, time.Now().Add(c.kept)})
	c.bytes += len(content)
	for c.bytes > c.limit {
		c.drop(c.order.Back())
	}
}

func (c *cache) drop(element *list.Element) {
	entry := c.order.Remove(element).(*cached)
	delete(c.entries, entry.key)
	c.bytes -= len(entry.content)
}
