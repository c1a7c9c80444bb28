#include "runtime/cache/cache_record.hpp"

namespace runtime {

CacheRecord record_of(const Result& result)
{
    CacheRecord record;
    record.warnings = result.warnings;
    for (const Heard& h : result.heard) record.heard.push_back({name_of(h.from), h.frame, h.text});
    record.figures = result.figures;
    for (const auto& t : result.told) {
        record.told.push_back({name_of(t->from), t->frame, t->node, t->type, t->figures});
    }
    for (const Written& w : result.files) {
        record.files.push_back({w.path.string(), name_of(w.digest)});
    }
    record.seconds = result.seconds;
    record.bytes = result.bytes;
    return record;
}

void take_record(const CacheRecord& record, Result& result)
{
    std::vector<graph::ContentName> names;
    for (const CacheRecord::Output& output : record.outputs) names.push_back(output.name);
    result.know_names(std::move(names));
    result.warnings = record.warnings;
    for (const CacheRecord::Heard& h : record.heard) {
        result.heard.push_back({key_of(h.from), h.frame, h.text});
    }
    result.figures = record.figures;
    for (const CacheRecord::Told& t : record.told) {
        result.told.push_back(
            std::make_shared<Told>(Told{key_of(t.from), t.frame, t.node, t.type, t.figures}));
    }
    for (const CacheRecord::WrittenFile& f : record.files) {
        result.files.push_back({f.path, key_of(f.digest)});
    }
    result.seconds = record.seconds;
    result.bytes = record.bytes;
}

}  // namespace runtime
