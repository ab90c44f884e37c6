// SPDX-License-Identifier: Apache-2.0

package guard

import (
	"fmt"
	"math"
	"net/http"
	"strconv"
	"strings"
	"sync"
	"time"

	"golang.org/x/time/rate"
	"google.golang.org/grpc/codes"

	"enfilade/gateway/internal/rest"
)

// Rates of what one address may ask for. 0: as much as it likes.
type Rates struct {
	CallsPerSecond float64
	TilesPerSecond float64 // requests of tiles; these do not count as calls
	Exports        int     // at once: what the server renders for each
}

// DefaultRates leave a dashboard and a few programs at one address undisturbed, and stop a loop.
func DefaultRates() Rates { return Rates{CallsPerSecond: 50, TilesPerSecond: 1000, Exports: 2} }

// Seconds of calls that a client which was quiet may send at once.
const burstSeconds = 4

// Clients that are remembered; then those that owe nothing are forgotten.
const maxClients = 4096

func newBucket(perSecond float64) *rate.Limiter {
	if perSecond <= 0 {
		return rate.NewLimiter(rate.Inf, 0)
	}
	return rate.NewLimiter(rate.Limit(perSecond), max(1, int(perSecond*burstSeconds)))
}

type client struct {
	calls, tiles *rate.Limiter
	exports      int
}

func (c *client) owesNothing(now time.Time) bool {
	for _, bucket := range []*rate.Limiter{c.calls, c.tiles} {
		if bucket.Limit() != rate.Inf && bucket.TokensAt(now) < float64(bucket.Burst()) {
			return false
		}
	}
	return c.exports == 0
}

type clients struct {
	rates  Rates
	mutex  sync.Mutex
	byName map[string]*client
}

// The caller holds the mutex.
func (c *clients) named(name string, now time.Time) *client {
	if found := c.byName[name]; found != nil {
		return found
	}
	if len(c.byName) >= maxClients {
		for other, state := range c.byName {
			if state.owesNothing(now) {
				delete(c.byName, other)
			}
		}
	}
	made := &client{calls: newBucket(c.rates.CallsPerSecond), tiles: newBucket(c.rates.TilesPerSecond)}
	c.byName[name] = made
	return made
}

// take returns how long the client must wait: 0 if it may go on.
func (c *clients) take(name string, tile bool) time.Duration {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	now := time.Now()
	bucket := c.named(name, now).calls
	if tile {
		bucket = c.named(name, now).tiles
	}
	token := bucket.ReserveN(now, 1)
	wait := token.DelayFrom(now)
	if wait > 0 {
		token.CancelAt(now)
	}
	return wait
}

func (c *clients) beginExport(name string) bool {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	client := c.named(name, time.Now())
	if c.rates.Exports > 0 && client.exports >= c.rates.Exports {
		return false
	}
	client.exports++
	return true
}

func (c *clients) endExport(name string) {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	c.byName[name].exports--
}

func isTile(path string) bool {
	return strings.Contains(path, "/tiles/") || strings.Contains(path, "/tiles:") || strings.Contains(path, "/mvt/")
}

func isExport(path string) bool {
	// The files of a prior map are stored: the server renders nothing, and a page shows several at once.
	if strings.Contains(path, "/priorMaps/") {
		return false
	}
	for _, end := range []string{":export", "/files", "/graph.geojson", "/trajectory.csv", "/composite.png", "/mvt.json"} {
		if strings.HasSuffix(path, end) {
			return true
		}
	}
	return strings.Contains(path, "/files/")
}

func refuse(w http.ResponseWriter, wait time.Duration, message string) {
	w.Header().Set("Retry-After", strconv.Itoa(max(1, int(math.Ceil(wait.Seconds())))))
	rest.WriteStatus(w, http.StatusTooManyRequests, codes.ResourceExhausted, message)
}

// Pages come from memory and are not counted, so that they load whatever a program at the same address does.
func limitRates(next http.Handler, rates Rates) http.Handler {
	all := &clients{rates: rates, byName: map[string]*client{}}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		path := r.URL.Path
		if !strings.HasPrefix(path, "/v1/") {
			next.ServeHTTP(w, r)
			return
		}
		name, tile := rest.CallerOf(r), isTile(path)
		if wait := all.take(name, tile); wait > 0 {
			what, limit := "calls", rates.CallsPerSecond
			if tile {
				what, limit = "requests of tiles", rates.TilesPerSecond
			}
			refuse(w, wait, fmt.Sprintf("more than %g %s a second came from your address: send fewer, or ask for more "+
				"in one call", limit, what))
			return
		}
		if isExport(path) {
			if !all.beginExport(name) {
				refuse(w, time.Second, fmt.Sprintf("%d exports for your address are under way: wait for one to end",
					rates.Exports))
				return
			}
			defer all.endExport(name)
		}
		next.ServeHTTP(w, r)
	})
}
